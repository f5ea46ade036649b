// SPDX-License-Identifier: GPL-3.0-or-later
//
// The look of what is shown: a section for each layer, and what the whole picture has: background, annotations, the
// direction from which it is seen.
import {create, type DescField, type Message} from '@bufbuild/protobuf';
import {lookFrom, toggleProjection} from './camera';
import {h, iconButton, setChildren, setOptions} from './dom';
import {AnnotationsSchema, CameraSchema, ColorBySchema, LayerSchema, PointsStyleSchema, PointsStyle_KnotSchema, ViewSchema, type Layer, type Manifest} from
    './generated/protocol/mote_pb';
import {layerKinds, type LayerKind, type Model} from './model';
import {messagePanel, refreshEvent, type PanelSettings, type Place} from './panel';

/// What particles have numbers of besides their columns, of docs/NUMBERS.md.
const derived = ['r', 'theta', 'xp', 'yp', 'p', 'pr', 'delta', 'gamma', 'energy', 'zeta', 'tau'];

export const columnsOf = (manifest: Manifest | undefined): string[] => {
    const columns = manifest?.particles?.columns.map((column) => column.name) ?? [];
    return columns.length > 0 ? [...new Set([...columns, ...derived])] : [];
};

const mostNameBytes = 200;
let lastName = 0;

/// What of a typed text a layer can be called (protocol/mote.proto): no control characters, and not too long.
function nameOf(typed: string): string {
    const encoder = new TextEncoder();
    let name = '', bytes = 0;
    for (const character of typed.replace(/\p{Cc}/gu, '')) {
        bytes += encoder.encode(character).length;
        if (bytes > mostNameBytes) break;
        name += character;
    }
    return name.trim();
}

/// The section of a layer. It stays while the layer does, so that a press on a control ends on it and what has the focus
/// keeps it; what it says of the layer's kind is made anew for another kind alone.
interface Row {
    layer: Layer;
    manifest: Manifest | undefined;
    kind: string | undefined;
    readonly place: HTMLElement;
    /// What the layer is like now.
    refresh(): void;
}

export class LayerPanels {
    onSave: () => void = () => {};
    onOpen: (file: File) => void = () => {};
    private rows: Row[] = [];
    private whole: HTMLElement[] | undefined;

    constructor(private readonly place: HTMLElement, private readonly model: Model) {}

    draw(): void {
        const {layers} = this.model.view;
        const before = [...this.rows];
        const take = (test: (row: Row) => boolean): Row | undefined => {
            const at = before.findIndex(test);
            return at < 0 ? undefined : before.splice(at, 1)[0];
        };
        // A view that was loaded has layers of its own, which may be those of before.
        const kept = layers.map((layer) => take((row) => row.layer === layer));
        this.rows = layers.map((layer, i) => kept[i] ?? take((row) => row.layer.dataset === layer.dataset) ?? this.row(layer));
        this.rows.forEach((row, i) => {
            row.layer = layers[i];
            row.refresh();
        });
        this.whole ??= [this.picture(), this.camera()];
        setChildren(this.place, layers.length > 0 ? [...this.rows.map(({place}) => place), ...this.whole] : []);
        this.refresh();
    }

    /// Fields may have other values.
    private refresh(): void {
        for (const each of this.place.querySelectorAll('.row, .curve-box')) each.dispatchEvent(new Event(refreshEvent));
    }

    private settings(row: Row): PanelSettings {
        return {
            changed: (moving, field) => {
                this.complete(row.layer, field);
                this.model.wanted(moving);
            },
            words: (field) => field.name === 'column' ? columnsOf(row.manifest) : undefined,
            domain: (field) => domainOf(field, row.layer, row.manifest),
        };
    }

    /// Points have a curve of their own, or are linked to the volume's: never both.
    private complete(layer: Layer, field: DescField): void {
        const points = layer.kind.case === 'particles' ? layer.kind.value.points : undefined;
        if (!points || field.parent !== PointsStyleSchema) return;
        if (field.name === 'curve') points.linked = points.curve.length > 0 ? false : undefined;
        if (field.name === 'linked' && points.linked !== false) points.curve = [];
        if (field.name === 'linked' && points.linked === false && points.curve.length === 0)
            points.curve = [create(PointsStyle_KnotSchema, {density: 0, fraction: 1})];
        this.refresh();
    }

    private row(layer: Layer): Row {
        const heading = h('span', {title: layer.dataset});
        const eye = this.eye(() => row.layer);
        const remove = iconButton('close', '', () => this.model.remove(this.model.view.layers.indexOf(row.layer)));
        const dataset = layer.dataset.slice(layer.dataset.indexOf('/') + 1);
        const [name, nameRow] = this.name(() => row.layer, dataset);
        const [kind, kindRow] = this.kind(() => row.layer);
        const style = h('div');
        const place = h('section', {class: 'section'}, h('h2', {}, heading, remove, eye), nameRow, kindRow, style);
        const refresh = () => {
            const called = row.layer.name || dataset;
            heading.textContent = called;
            place.setAttribute('aria-label', called);
            for (const [button, act] of [[eye, 'Show'], [remove, 'Remove']] as const) {
                button.setAttribute('aria-label', `${act} ${called}`);
                button.title = `${act} ${called}`;
            }
            eye.setAttribute('aria-pressed', String(!row.layer.hidden));
            remove.hidden = this.model.view.layers.length < 2;
            if (name !== document.activeElement) name.value = row.layer.name;
            const manifest = this.model.manifests.get(row.layer.dataset);
            if (row.kind === row.layer.kind.case && row.manifest === manifest) return;
            row.kind = row.layer.kind.case;
            row.manifest = manifest;
            const kinds = layerKinds(manifest?.kind ?? '');
            kindRow.hidden = kinds.length < 2;
            setOptions(kind, kinds.map((each) => [each, each === 'ink' ? 'pen and ink' : each]));
            kind.value = row.kind ?? '';
            style.replaceChildren(...this.style(row));
        };
        const row: Row = {layer, manifest: undefined, kind: undefined, place, refresh};
        return row;
    }

    /// What its kind has to be set.
    private style(row: Row): HTMLElement[] {
        const settings = this.settings(row);
        const kindField = LayerSchema.oneofs.find((oneof) => oneof.name === 'kind')!
            .fields.find((field) => field.localName === row.layer.kind.case)!;
        const style: Place = {get: () => row.layer.kind.value as Message | undefined, make: () => row.layer.kind.value as Message};
        const whole: Place = {get: () => row.layer, make: () => row.layer};
        const panels = [messagePanel(kindField.message!, style, settings),
                        messagePanel(LayerSchema, whole, {...settings, skip: ['transform', 'hidden']})];
        if (row.manifest?.particles && columnsOf(row.manifest).length > 0) panels.push(this.colorBy(row, settings));
        return panels;
    }

    /// Whether the layer is drawn.
    private eye(layer: () => Layer): HTMLElement {
        const button = iconButton('eye', '', () => {
            layer().hidden = !layer().hidden;
            button.setAttribute('aria-pressed', String(!layer().hidden));
            this.model.wanted();
        });
        return button;
    }

    /// What people call it.
    private name(layer: () => Layer, dataset: string): [HTMLInputElement, HTMLElement] {
        const id = `layer-name-${++lastName}`;
        const input = h('input', {type: 'text', id, placeholder: dataset});
        input.addEventListener('change', () => {
            layer().name = input.value = nameOf(input.value);
            this.model.wanted();
            this.model.onLayers();
        });
        return [input, h('div', {class: 'row'}, h('label', {for: id}, 'Name'), input)];
    }

    private kind(layer: () => Layer): [HTMLSelectElement, HTMLElement] {
        const select = h('select', {'aria-label': 'Drawn as'});
        select.addEventListener('change', () => {
            const kind = select.value as LayerKind;
            layer().kind = create(LayerSchema, {kind: {case: kind, value: {}} as never}).kind;
            this.model.wanted();
            this.model.onLayers();
        });
        return [select, h('div', {class: 'row', hidden: true}, h('label', {}, 'Drawn as'), select)];
    }

    private colorBy(row: Row, settings: PanelSettings): HTMLElement {
        const place: Place = {get: () => row.layer.colorBy, make: () => row.layer.colorBy ??= create(ColorBySchema)};
        const changed = (moving: boolean, field: DescField) => {
            if (row.layer.colorBy && !row.layer.colorBy.column) row.layer.colorBy = undefined;
            settings.changed(moving, field);
        };
        return h('details', {class: 'group', open: !!row.layer.colorBy}, h('summary', {}, 'Colour by'),
                 messagePanel(ColorBySchema, place, {...settings, changed}));
    }

    private picture(): HTMLElement {
        const {model} = this;
        const changed = (moving: boolean) => model.wanted(moving);
        const whole: Place = {get: () => model.view, make: () => model.view};
        const annotations: Place = {get: () => model.view.annotations,
                                    make: () => model.view.annotations ??= create(AnnotationsSchema)};
        return h('section', {class: 'section', 'aria-label': 'Picture'}, h('h2', {}, h('span', {}, 'Picture')),
                 messagePanel(ViewSchema, whole, {changed, skip: ['scale']}), messagePanel(AnnotationsSchema, annotations, {
                     changed, skip: ['print_width']}), this.files());
    }

    private files(): HTMLElement {
        const input = h('input', {type: 'file', accept: '.json,application/json', class: 'hidden-visually', 'aria-label': 'Open a view',
                                  tabIndex: -1});
        input.addEventListener('change', () => {
            if (input.files?.[0]) this.onOpen(input.files[0]);
            input.value = '';
        });
        return h('div', {class: 'buttons'},
                 h('button', {type: 'button', class: 'button', onclick: () => this.onSave()}, 'Save view'),
                 h('button', {type: 'button', class: 'button', onclick: () => input.click()}, 'Open view'), input);
    }

    private camera(): HTMLElement {
        const sides = ['x', 'y', 'z'].flatMap((axis, i) => [true, false].map((positive) => {
            const name = (positive ? '+' : '−') + axis;
            return h('button', {type: 'button', class: 'button', 'aria-label': `Look from ${name}`, onclick: () => {
                if (this.model.camera) this.model.setCamera(lookFrom(this.model.camera, i, positive));
            }}, name);
        }));
        const place: Place = {get: () => this.model.camera, make: () => this.model.camera ??= create(CameraSchema)};
        return h('section', {class: 'section', 'aria-label': 'Camera'}, h('h2', {}, h('span', {}, 'Camera')),
                 messagePanel(CameraSchema, place, {changed: (moving) => this.model.wanted(moving),
                                                    skip: ['orthographic_height']}),
                 h('div', {class: 'buttons'}, ...sides, h('button', {type: 'button', class: 'button', onclick: () => {
                     if (this.model.camera) this.model.setCamera(toggleProjection(this.model.camera));
                 }}, 'Projection')));
    }
}

/// Over what a curve goes: the scaled log density of particles, the values of a volume.
function domainOf(field: DescField, layer: Layer, manifest: Manifest | undefined) {
    const first = field.fieldKind === 'list' && field.listKind === 'message' ? field.message.fields[0].name : '';
    if (first === 'density' || (first === 'value' && manifest?.particles)) {
        const step = manifest?.particles?.steps[layer.step];
        return {from: 0, to: 1, unit: '', histogram: (step?.densityHistogram ?? []).map(Number)};
    }
    const volume = manifest?.hybrid;
    if (first !== 'value' || !volume) return undefined;
    const histogram = (volume.steps[layer.step] ?? volume.steps[0])?.histogram.map(Number) ?? [];
    return {from: volume.valueMin, to: volume.valueMax, unit: volume.valueUnit, histogram};
}
