// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which particles are meant: drawn round on the picture, or between two values of a column. They are shown over the
// others or alone, and the numbers beside are theirs.
import {clone, create} from '@bufbuild/protobuf';
import {h, icon, setOptions, tell, trimmed} from './dom';
import {HighlightSchema, SelectionSchema, type Axis, type Layer, type Manifest, type ParticlesManifest, type Selection, type View} from
    './generated/protocol/mote_pb';
import type {Gestures, Point} from './gestures';
import {columnsOf} from './layers';
import type {Model} from './model';

const mostCorners = 400;

/// The axes of a step with their bounds.
function axesOf(plot: ParticlesManifest, step: number): Axis[] {
    const before = plot.axes.slice(3 * (1 + step), 3 * (2 + step));  // where they stood before a step had its own
    const own = plot.steps[step]?.axes ?? [];
    return own.length === 3 ? own : before.length === 3 ? before : plot.axes.slice(0, 3);
}

/// From a step's box to metres, row by row, of a plot along x, y and z.
function placeOf(plot: ParticlesManifest, step: number): number[] {
    const place = new Array<number>(16).fill(0);
    place[15] = 1;
    axesOf(plot, step).forEach((axis, i) => {
        const along = 'xyz'.indexOf(axis.name);
        place[4 * along + i] = (axis.max - axis.min) / 2;
        place[4 * along + 3] = (axis.max + axis.min) / 2;
    });
    return place;
}

/// Layer to world, row by row: of a view in metres what its place undergoes (docs/PICTURE.md, "Layers in metres").
function worldOf(view: View, layer: Layer, plot: ParticlesManifest | undefined): number[] {
    if (view.space === '' || !plot) return layer.transform;
    const {step, share} = layer.towards ?? {step: layer.step, share: 0};
    const next = placeOf(plot, step);
    const place = placeOf(plot, layer.step).map((value, i) => value * (1 - share) + next[i]! * share);
    const own = layer.transform.length === 16 ? layer.transform : [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
    return place.map((_, at) => {
        const [row, column] = [at >> 2, at & 3];
        const sum = [0, 1, 2, 3].reduce((all, k) => all + own[4 * row + k]! * place[4 * k + column]!, 0);
        return sum * (view.stretch[row] ?? 1);
    });
}

const pair = (first: number, second: number) =>
    ({values: [first, second].map((value) => ({kind: {case: 'numberValue' as const, value}}))});

/// The plot in which a lasso is drawn, so that it holds the same particles in all plots of the run. Nothing where it has
/// no columns for its axes; nor where each step has bounds of its own and the lasso is not of this step's particles:
/// then it stays where it is on the screen.
function plotOf(manifest: Manifest | undefined, step: number, madeHere: boolean) {
    const plot = manifest?.particles;
    if (!plot) return {};
    const axes = axesOf(plot, step), columns = new Set(columnsOf(manifest));
    const own = axes.some((axis, i) => axis.min !== plot.axes[i]!.min || axis.max !== plot.axes[i]!.max);
    if (axes.length !== 3 || (own && !madeHere) || !axes.every((axis) => columns.has(axis.name))) return {};
    return {axes: axes.map((axis) => axis.name), bounds: axes.map((axis) => pair(axis.min, axis.max))};
}

function wordsOf(selection: Selection): string {
    if (selection.lasso) return `Surrounded by a line of ${selection.lasso.points.length} corners.`;
    const range = selection.ranges[0];
    if (range) return `${range.column} from ${trimmed(range.min ?? -Infinity)} to ${trimmed(range.max ?? Infinity)}.`;
    return 'Chosen by the view.';
}

type Range = Selection['ranges'][number];

const limit = (name: string) => h('input', {type: 'number', step: 'any', 'aria-label': name, placeholder: name.toLowerCase()});

export class SelectionPanel {
    onChange: () => void = () => {};
    // Made once: a press on a control ends on it, and what has the focus keeps it, whatever changes meanwhile.
    private readonly words = h('p', {class: 'note'});
    private readonly column = h('select', {'aria-label': 'Column of the range'});
    private readonly least = limit('From');
    private readonly most = limit('To');
    private readonly range = h('div', {class: 'numbers'}, this.column, this.least, this.most);
    private readonly lassoButton = h('button', {type: 'button', class: 'button', id: 'lasso',
                                                onclick: () => this.toggleLasso()}, icon('lasso'), 'Lasso');
    private readonly clearButton = h('button', {type: 'button', class: 'button', onclick: () => this.clear()}, 'Clear');
    private readonly alone = h('input', {type: 'checkbox', class: 'switch', role: 'switch', id: 'alone'});
    private readonly aloneRow = h('div', {class: 'row'}, h('label', {for: 'alone'}, 'These alone'), this.alone);
    private readonly place = h('section', {class: 'section', 'aria-label': 'Selection'}, h('h2', {}, h('span', {}, 'Selection')),
                               this.words, this.range, h('div', {class: 'buttons'}, this.lassoButton, this.clearButton),
                               this.aloneRow);
    private drawing = false;

    constructor(private readonly model: Model, private readonly gestures: Gestures, private readonly stage: HTMLElement,
                private readonly marks: HTMLCanvasElement) {
        this.alone.addEventListener('change', () => this.selection && this.show(this.selection, this.alone.checked));
        for (const input of [this.column, this.least, this.most]) input.addEventListener('change', () => this.takeRange());
    }

    get element(): HTMLElement {
        return this.place;
    }

    /// What is selected of the first layer.
    get selection(): Selection | undefined {
        return this.model.layer?.select ?? this.model.layer?.highlight?.selection;
    }

    draw(): void {
        const {layer, manifest} = this.model;
        this.place.hidden = layer?.kind.case !== 'particles';
        if (this.place.hidden || !layer) return;
        const chosen = this.selection;
        this.words.textContent = chosen ? wordsOf(chosen) : 'All particles.';
        this.lassoButton.setAttribute('aria-pressed', String(this.drawing));
        this.clearButton.disabled = !chosen;
        this.aloneRow.hidden = !chosen;
        this.alone.checked = !!layer.select;
        this.drawRange(columnsOf(manifest), chosen?.ranges[0]);
    }

    private drawRange(columns: string[], range: Range | undefined): void {
        this.range.hidden = columns.length === 0;
        setOptions(this.column, columns.map((name) => [name, name]));
        if (range) this.column.value = range.column;
        for (const [input, value] of [[this.least, range?.min], [this.most, range?.max]] as const)
            if (input !== document.activeElement || range) input.value = value === undefined ? '' : trimmed(value);
    }

    private takeRange(): void {
        const [min, max] = [this.least, this.most].map((input) => input.value === '' ? undefined : Number(input.value));
        if (min === undefined && max === undefined) return;
        this.show(create(SelectionSchema, {ranges: [{column: this.column.value, min, max}], step: this.madeIn()}),
                  !!this.model.layer?.select);
    }

    /// Where particles have ids, the same ones are meant in every step.
    private madeIn(): number | undefined {
        return this.model.manifest?.particles?.ids ? this.model.layer?.step : undefined;
    }

    private show(selection: Selection, alone: boolean): void {
        const {layer} = this.model;
        if (!layer) return;
        layer.select = alone ? selection : undefined;
        layer.highlight = alone ? undefined
            : Object.assign(layer.highlight ?? create(HighlightSchema), {selection: clone(SelectionSchema, selection)});
        this.changed();
    }

    private clear(): void {
        const {layer} = this.model;
        if (!layer) return;
        layer.select = undefined;
        layer.highlight = undefined;
        this.changed();
    }

    private changed(): void {
        this.model.wanted();
        this.draw();
        this.onChange();
    }

    private toggleLasso(): void {
        this.drawing = !this.drawing;
        this.stage.classList.toggle('lasso', this.drawing);
        this.gestures.onLasso = this.drawing ? (points, done) => this.lasso(points, done) : undefined;
        if (this.drawing) tell('Draw a line around particles.');
        this.draw();
    }

    private lasso(points: Point[], done: boolean): void {
        this.sketch(done ? [] : points);
        if (!done) return;
        this.toggleLasso();
        const {camera, size, layer, view, manifest} = this.model;
        if (points.length < 3 || !camera || !layer) return;
        const every = Math.ceil(points.length / mostCorners);
        const corners = points.filter((_, i) => i % every === 0);
        const step = this.madeIn();
        this.show(create(SelectionSchema, {
            step,
            lasso: {camera, aspect: size.width / size.height, transform: worldOf(view, layer, manifest?.particles),
                    points: corners.map((point) => pair(point.x, point.y)),
                    ...plotOf(manifest, layer.step, step !== undefined)},
        }), !!layer.select);
    }

    private sketch(points: Point[]): void {
        const {clientWidth: width, clientHeight: height} = this.stage;
        this.marks.width = width;
        this.marks.height = height;
        const context = this.marks.getContext('2d')!;
        if (points.length < 2) return;
        context.beginPath();
        for (const point of points) context.lineTo(point.x * width, point.y * height);
        context.closePath();
        context.fillStyle = 'rgb(255 179 92 / 15%)';
        context.strokeStyle = '#ffb35c';
        context.lineWidth = 2;
        context.fill();
        context.stroke();
    }
}
