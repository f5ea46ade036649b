// SPDX-License-Identifier: GPL-3.0-or-later
//
// The list of datasets: what there is, a small picture of each, a search.
import type {Catalogue_Entry} from './generated/protocol/mote_pb';
import {amount, h, iconButton, setChildren, tell} from './dom';
import {layerKinds, type Model} from './model';

const kindNames: Record<string, string> = {
    particles: 'particles', hybrid: 'volume', stipple: 'stipples', mesh: 'mesh', image: 'image',
};

function aboutOf(entry: Catalogue_Entry): string {
    const parts = [entry.kind === 'particles' && entry.particles > 0n ? `${amount(Number(entry.particles))} particles`
                                                                      : kindNames[entry.kind] ?? entry.kind];
    if (entry.steps > 1) parts.push(`${entry.steps} steps`);
    if (entry.bytes > 0n) parts.push(`${amount(Number(entry.bytes))}${entry.bytes < 1000n ? ' ' : ''}B`);
    if (entry.preparedMs > 0n) parts.push(new Date(Number(entry.preparedMs)).toISOString().slice(0, 10));
    return parts.join(' · ');
}

/// By what the list is sorted: the name that people read, and what comes first.
const orders: Record<string, (one: Catalogue_Entry, other: Catalogue_Entry) => number> = {
    'name': () => 0,  // as the server tells them
    'date, newest first': (one, other) => Number(other.preparedMs - one.preparedMs),
    'size, largest first': (one, other) => Number(other.bytes - one.bytes),
};

/// The row of a dataset, which stays while a run grows, so that a click meets the button that it began on.
interface Row {
    entry: Catalogue_Entry;
    readonly place: HTMLElement;
    readonly choose: HTMLButtonElement;
    readonly about: HTMLElement;
}

export class CatalogueList {
    /// Puts a small picture of a dataset into a canvas, some time.
    onThumbnail: (entry: Catalogue_Entry, place: HTMLCanvasElement) => void = () => {};
    private readonly list = h('ul', {class: 'datasets'});
    private readonly search = h('input', {type: 'search', placeholder: 'Search datasets', 'aria-label': 'Search datasets'});
    private readonly order = h('select', {'aria-label': 'Sort by'},
                               ...Object.keys(orders).map((name) => h('option', {value: name}, `by ${name}`)));
    private readonly thumbnails = new Map<string, HTMLCanvasElement>();
    private readonly rows = new Map<string, Row>();

    constructor(place: HTMLElement, private readonly model: Model) {
        this.search.addEventListener('input', () => this.draw());
        this.order.addEventListener('change', () => this.draw());
        place.append(h('div', {class: 'search'}, this.search, this.order), this.list);
    }

    draw(): void {
        const words = this.search.value.toLowerCase().split(/\s+/);
        const found = this.model.catalogue.filter((entry) => {
            const text = `${entry.name} ${entry.title} ${entry.kind}`.toLowerCase();
            return layerKinds(entry.kind).length > 0 && words.every((word) => text.includes(word));
        });
        found.sort(orders[this.order.value]);
        const none = this.model.catalogue.length > 0 ? 'No dataset matches.' : 'There are no datasets here yet.';
        setChildren(this.list, found.length > 0 ? found.map((entry) => this.show(entry)) : [h('li', {class: 'none'}, none)]);
        this.mark();
    }

    /// Which ones are shown.
    mark(): void {
        const shown = new Set(this.model.view.layers.map((layer) => layer.dataset));
        for (const item of this.list.querySelectorAll<HTMLElement>('li[data-name]')) {
            const is = shown.has(item.dataset.name!);
            item.classList.toggle('shown', is);
            if (is) item.firstElementChild!.setAttribute('aria-current', 'true');
            else item.firstElementChild!.removeAttribute('aria-current');
        }
    }

    private show(entry: Catalogue_Entry): HTMLElement {
        const row = this.rows.get(entry.name) ?? this.row(entry);
        this.rows.set(entry.name, row);
        row.entry = entry;
        row.choose.title = entry.title || entry.name;
        row.about.textContent = aboutOf(entry);
        return row.place;
    }

    private row(entry: Catalogue_Entry): Row {
        const act = (work: Promise<void>) => work.catch((error) => tell(String(error.message), true));
        const name = entry.name.slice(entry.name.indexOf('/') + 1);
        const about = h('span', {class: 'about'});
        const choose = h('button', {type: 'button', class: 'dataset', onclick: () => act(this.model.open(row.entry))},
                         this.thumbnail(entry), h('span', {class: 'name'}, name), about);
        const add = iconButton('plus', `Add ${name} to the picture`, () => act(this.model.add(row.entry)));
        add.classList.add('add');
        const place = h('li', {}, choose, add);
        place.dataset.name = entry.name;
        const row: Row = {entry, place, choose, about};
        return row;
    }

    private thumbnail(entry: Catalogue_Entry): HTMLCanvasElement {
        const made = this.thumbnails.get(entry.name);
        if (made) return made;
        const canvas = h('canvas', {class: 'thumbnail', width: 116, height: 84, 'aria-hidden': 'true'});
        this.thumbnails.set(entry.name, canvas);
        this.onThumbnail(entry, canvas);
        return canvas;
    }
}
