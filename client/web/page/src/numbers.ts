// SPDX-License-Identifier: GPL-3.0-or-later
//
// Numbers of the particles that are shown or selected: statistics, a histogram of one column or two, the particle that
// was picked. They are asked for while their tab is seen, for the present step.
import {create} from '@bufbuild/protobuf';
import {amount, h, quantity, setOptions, tell, trimmed} from './dom';
import {colorMaps} from './generated/color_maps';
import {PickQuerySchema, StatisticsQuerySchema, type Histogram, type Picked} from './generated/protocol/mote_pb';
import {columnsOf} from './layers';
import type {Model} from './model';
import type {SelectionPanel} from './selection';
import {ServerError, type Server} from './server';

const bins = 96;
const first = ['n_particle', 'charge', 'mean_energy', 'sigma_x', 'sigma_y', 'sigma_z', 'norm_emit_x', 'norm_emit_y',
               'twiss_beta_x', 'twiss_beta_y'];
const unitsOf: Record<string, string> = {
    x: 'm', y: 'm', z: 'm', r: 'm', t: 's', px: 'eV/c', py: 'eV/c', pz: 'eV/c', p: 'eV/c', pr: 'eV/c', energy: 'eV',
    xp: 'rad', yp: 'rad', theta: 'rad', zeta: 'm', tau: 's',
};

/// Of a statistic, by its name: docs/NUMBERS.md.
function statisticUnit(name: string): string {
    const of = /^(?:mean|sigma|min|max)_(\w+)$/.exec(name);
    if (of) return unitsOf[of[1]] ?? '';
    if (/^norm_emit_\w$/.test(name) || /^emit_\w$/.test(name) || /^twiss_beta/.test(name)) return 'm';
    return name === 'charge' ? 'C' : '';
}

const edge = (edges: number[] | undefined, last: boolean) => edges ? edges[last ? edges.length - 1 : 0] : 0;

export class NumbersPanel {
    private readonly statistics = h('section', {class: 'section', 'aria-label': 'Statistics'});
    private readonly histogram = h('section', {class: 'section', 'aria-label': 'Histogram'});
    private readonly picked = h('section', {class: 'section', 'aria-label': 'Picked particle', hidden: true});
    private readonly plot = h('canvas', {class: 'plot', role: 'img', 'aria-label': 'Histogram'});
    private readonly caption = h('p', {class: 'note'});
    private readonly choices = ['Horizontal', 'Vertical'].map((label) => h('select', {'aria-label': label}));
    private columns: [string, string] = ['', ''];
    private shownFor = '';
    private asked = 0;
    private timer = 0;

    constructor(private readonly place: HTMLElement, private readonly server: Server, private readonly model: Model,
                private readonly selection: SelectionPanel) {
        this.choices.forEach((choice, which) => choice.addEventListener('change', () => {
            this.columns[which] = choice.value;
            this.refresh();
        }));
        this.histogram.append(h('h2', {}, h('span', {}, 'Histogram')), h('div', {class: 'numbers'}, ...this.choices), this.plot, this.caption);
        place.append(selection.element, this.picked, this.statistics, this.histogram);
        selection.onChange = () => this.refresh();
    }

    /// The layers changed: controls are made anew.
    draw(): void {
        this.selection.draw();
        const columns = columnsOf(this.model.manifest);
        const particles = this.model.layer?.kind.case === 'particles';
        this.statistics.hidden = this.histogram.hidden = !particles;
        if (!this.model.layer || !particles) {
            this.statistics.hidden = false;
            this.shownFor = '';
            ++this.asked;
            this.statistics.replaceChildren(h('p', {class: 'note'}, 'Only particles have numbers: choose a dataset of particles.'));
            return;
        }
        if (!columns.includes(this.columns[0])) this.columns = [columns[0] ?? '', ''];
        const options = columns.map((name): [string, string] => [name, name]);
        [options, [['', 'counts'] as [string, string], ...options]].forEach((each, which) => {
            setOptions(this.choices[which], each);
            this.choices[which].value = this.columns[which];
        });
        this.refresh();
    }

    /// The step, the selection or the dataset may be another.
    refresh(): void {
        clearTimeout(this.timer);
        if (this.place.hidden || this.model.layer?.kind.case !== 'particles') return;
        this.timer = window.setTimeout(() => void this.ask(), 120);
    }

    private async ask(): Promise<void> {
        const {layer} = this.model;
        if (!layer || !this.model.manifest?.particles) return;
        const of = {dataset: layer.dataset, steps: `${layer.step}:${layer.step}:1`, select: this.selection.selection};
        const key = JSON.stringify([of.dataset, of.steps, this.columns, of.select], (_, value) =>
            typeof value === 'bigint' ? String(value) : value);
        if (key === this.shownFor) return;
        this.shownFor = key;
        const mine = ++this.asked;
        try {
            const [numbers] = await this.server.query({
                ...of, what: {case: 'statistics', value: create(StatisticsQuerySchema)}} as never);
            if (mine !== this.asked) return;
            this.showStatistics(numbers.answer.statistics?.names ?? [], numbers.answer.statistics?.values ?? []);
            if (!this.columns[0]) return;
            const axes = this.columns.filter((column) => column !== '')
                .map((column) => ({column, bins: this.columns[1] ? bins : 2 * bins, range: []}));
            const [counts] = await this.server.query({...of, what: {case: 'histogram', value: {axes}}} as never);
            if (mine === this.asked && counts.answer.histogram) this.showHistogram(counts.answer.histogram, counts.payload);
        } catch (error) {
            this.shownFor = '';
            if (mine === this.asked && error instanceof ServerError) tell(error.message, true);
        }
    }

    private showStatistics(names: string[], values: number[]): void {
        const row = (name: string) => {
            const value = values[names.indexOf(name)];
            const text = name.startsWith('n_') ? amount(value) : quantity(value, statisticUnit(name));
            return h('tr', {}, h('th', {scope: 'row'}, name), h('td', {}, text));
        };
        const known = names.filter((name) => Number.isFinite(values[names.indexOf(name)]));
        const begin = first.filter((name) => known.includes(name));
        const rest = known.filter((name) => !first.includes(name));
        this.statistics.replaceChildren(
            h('h2', {}, h('span', {}, 'Statistics')), h('table', {}, h('tbody', {}, ...begin.map(row))),
            h('details', {class: 'group'}, h('summary', {}, `All ${known.length}`),
              h('table', {}, h('tbody', {}, ...rest.map(row)))));
    }

    private showHistogram(histogram: Histogram, payload: Uint8Array): void {
        const counts = new Float64Array(payload.slice().buffer);
        const [x, y] = histogram.axes.map((axis) => axis.values);
        const ratio = devicePixelRatio;
        this.plot.width = Math.round(this.plot.clientWidth * ratio);
        this.plot.height = Math.round(this.plot.clientHeight * ratio);
        if (y) this.drawMap(counts, x.length - 1, y.length - 1);
        else this.drawBars(counts);
        const [a, b] = this.columns;
        const range = (column: string, edges: number[]) =>
            `${column} ${[false, true].map((last) => quantity(edge(edges, last), unitsOf[column] ?? '', 3)).join(' … ')}`;
        const words = `${range(a, x)}${y ? `, ${range(b, y)}` : ''} · ${amount(Number(histogram.particles))} particles`;
        this.caption.textContent = words;
        this.plot.setAttribute('aria-label', `Histogram: ${words}`);
    }

    private drawBars(counts: Float64Array): void {
        const context = this.plot.getContext('2d')!;
        const {width, height} = this.plot;
        const most = Math.max(...counts, Number.MIN_VALUE);
        context.fillStyle = getComputedStyle(this.plot).getPropertyValue('--accent');
        counts.forEach((count, i) => {
            const size = Math.max(count / most, 0) * height * 0.94;
            const from = Math.round(i * width / counts.length);
            context.fillRect(from, height - size, Math.max(1, Math.round((i + 1) * width / counts.length) - from), size);
        });
    }

    private drawMap(counts: Float64Array, columns: number, rows: number): void {
        const most = Math.log1p(Math.max(...counts));
        const image = new ImageData(columns, rows);
        const stops = colorMaps.viridis.map((color) => [1, 3, 5].map((at) => parseInt(color.slice(at, at + 2), 16)));
        for (let i = 0; i < columns; ++i) for (let j = 0; j < rows; ++j) {
            const count = counts[i * rows + j];
            if (!(count > 0)) continue;
            const at = Math.log1p(count) / most * (stops.length - 1);
            const [low, share] = [Math.min(Math.floor(at), stops.length - 2), at - Math.min(Math.floor(at), stops.length - 2)];
            const to = 4 * ((rows - 1 - j) * columns + i);
            for (let c = 0; c < 3; ++c) image.data[to + c] = stops[low][c] * (1 - share) + stops[low + 1][c] * share;
            image.data[to + 3] = 255;
        }
        const small = new OffscreenCanvas(columns, rows);
        small.getContext('2d')!.putImageData(image, 0, 0);
        const context = this.plot.getContext('2d')!;
        context.imageSmoothingEnabled = false;
        context.drawImage(small, 0, 0, this.plot.width, this.plot.height);
    }

    /// The particle that is seen at a place of the picture.
    async pick(x: number, y: number): Promise<void> {
        const {layer, size} = this.model;
        if (layer?.kind.case !== 'particles' || !this.model.camera) return;
        const at = create(PickQuerySchema, {view: this.model.whole(), x: x * size.width, y: y * size.height});
        try {
            const [found] = await this.server.query({
                dataset: layer.dataset, steps: `${layer.step}:${layer.step}:1`, what: {case: 'pick', value: at}} as never);
            const picked = found.answer.picked;
            if (picked?.found) this.showPicked(picked);
            else tell('There is no particle here.');
        } catch (error) {
            tell((error as Error).message, true);
        }
    }

    private showPicked(picked: Picked): void {
        const id = picked.id === undefined ? `row ${picked.row}` : `id ${picked.id}`;
        this.picked.hidden = false;
        this.picked.replaceChildren(
            h('h2', {}, h('span', {}, `Particle ${id}`)),
            h('table', {}, h('tbody', {}, ...picked.names.map((name, i) => h('tr', {}, h('th', {scope: 'row'}, name),
                h('td', {}, `${trimmed(picked.values[i], 6)} ${picked.units[i] === '1' ? '' : picked.units[i]}`))))));
        const words = picked.names.slice(0, 3).map((name, i) => `${name} ${trimmed(picked.values[i])} ${picked.units[i]}`);
        tell(`Particle ${id}: ${words.join(', ')}`);
    }
}
