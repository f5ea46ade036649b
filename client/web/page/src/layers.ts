// SPDX-License-Identifier: GPL-3.0-or-later
//
// The look of what is shown: a section for each layer, and what the whole picture has: background, annotations, the
// direction from which it is seen.
import {create, type DescField, type Message} from '@bufbuild/protobuf';
import {lookFrom, toggleProjection} from './camera';
import {h, iconButton} from './dom';
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

export class LayerPanels {
    onSave: () => void = () => {};
    onOpen: (file: File) => void = () => {};

    constructor(private readonly place: HTMLElement, private readonly model: Model) {}

    draw(): void {
        const {layers} = this.model.view;
        this.place.replaceChildren(...layers.map((layer, index) => this.layer(layer, index)),
                                   ...(layers.length > 0 ? [this.picture(), this.camera()] : []));
    }

    private settings(layer: Layer): PanelSettings {
        const manifest = this.model.manifests.get(layer.dataset);
        return {
            changed: (moving, field) => {
                this.complete(layer, field);
                this.model.wanted(moving);
            },
            words: (field) => field.name === 'column' ? columnsOf(manifest) : undefined,
            domain: (field) => domainOf(field, layer, manifest),
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
        for (const each of this.place.querySelectorAll('.row, .curve-box')) each.dispatchEvent(new Event(refreshEvent));
    }

    private layer(layer: Layer, index: number): HTMLElement {
        const manifest = this.model.manifests.get(layer.dataset);
        const settings = this.settings(layer);
        const kindField = LayerSchema.oneofs.find((oneof) => oneof.name === 'kind')!
            .fields.find((field) => field.localName === layer.kind.case)!;
        const style: Place = {get: () => layer.kind.value as Message | undefined, make: () => layer.kind.value as Message};
        const whole: Place = {get: () => layer, make: () => layer};
        const rows = [messagePanel(kindField.message!, style, settings),
                      messagePanel(LayerSchema, whole, {...settings, skip: ['transform', 'hidden']})];
        if (manifest?.particles && columnsOf(manifest).length > 0) rows.push(this.colorBy(layer, settings));
        const dataset = layer.dataset.slice(layer.dataset.indexOf('/') + 1);
        const name = layer.name || dataset;
        const remove = this.model.view.layers.length > 1
            && iconButton('close', `Remove ${name}`, () => this.model.remove(index));
        return h('section', {class: 'section', 'aria-label': name},
                 h('h2', {}, h('span', {title: layer.dataset}, name), this.eye(layer, name), remove),
                 this.name(layer, dataset), this.kind(layer, manifest), ...rows);
    }

    /// Whether the layer is drawn.
    private eye(layer: Layer, name: string): HTMLElement {
        const button = iconButton('eye', `Show ${name}`, () => {
            layer.hidden = !layer.hidden;
            button.setAttribute('aria-pressed', String(!layer.hidden));
            this.model.wanted();
        }, {'aria-pressed': !layer.hidden});
        return button;
    }

    /// What people call it.
    private name(layer: Layer, dataset: string): HTMLElement {
        const id = `layer-name-${this.model.view.layers.indexOf(layer)}`;
        const input = h('input', {type: 'text', id, value: layer.name, placeholder: dataset});
        input.addEventListener('change', () => {
            layer.name = nameOf(input.value);
            this.model.wanted();
            this.model.onLayers();
        });
        return h('div', {class: 'row'}, h('label', {for: id}, 'Name'), input);
    }

    private kind(layer: Layer, manifest: Manifest | undefined): HTMLElement | undefined {
        const kinds = layerKinds(manifest?.kind ?? '');
        if (kinds.length < 2) return undefined;
        const select = h('select', {'aria-label': 'Drawn as'},
                         ...kinds.map((kind) => h('option', {value: kind}, kind === 'ink' ? 'pen and ink' : kind)));
        select.value = layer.kind.case ?? '';
        select.addEventListener('change', () => {
            const kind = select.value as LayerKind;
            layer.kind = create(LayerSchema, {kind: {case: kind, value: {}} as never}).kind;
            this.model.wanted();
            this.model.onLayers();
        });
        return h('div', {class: 'row'}, h('label', {}, 'Drawn as'), select);
    }

    private colorBy(layer: Layer, settings: PanelSettings): HTMLElement {
        const place: Place = {get: () => layer.colorBy, make: () => layer.colorBy ??= create(ColorBySchema)};
        const changed = (moving: boolean, field: DescField) => {
            if (layer.colorBy && !layer.colorBy.column) layer.colorBy = undefined;
            settings.changed(moving, field);
        };
        return h('details', {class: 'group', open: !!layer.colorBy}, h('summary', {}, 'Colour by'),
                 messagePanel(ColorBySchema, place, {...settings, changed}));
    }

    private picture(): HTMLElement {
        const {view} = this.model;
        const changed = (moving: boolean) => this.model.wanted(moving);
        const whole: Place = {get: () => view, make: () => view};
        const annotations: Place = {get: () => view.annotations,
                                    make: () => view.annotations ??= create(AnnotationsSchema)};
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
