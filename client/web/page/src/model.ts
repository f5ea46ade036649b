// SPDX-License-Identifier: GPL-3.0-or-later
//
// Model: the view that is wanted, and what is known of its datasets. Whoever changes it says so; it is then asked for
// once a frame of the screen at most.
import {clone, create, fromBinary, toBinary} from '@bufbuild/protobuf';
import {usualAnnotations} from './generated/annotations';
import {LayerSchema, ViewSchema, type Camera, type Catalogue_Entry, type Layer, type Manifest, type View} from
    './generated/protocol/mote_pb';
import type {Server} from './server';

export type LayerKind = NonNullable<Layer['kind']['case']>;

/// The kinds of layer that draw a dataset of a kind, its own first (protocol/scene/dataset.cpp).
const kindsOf: Record<string, LayerKind[]> = {
    particles: ['particles', 'ink'], hybrid: ['hybrid', 'ink'], stipple: ['stipple', 'ink', 'mesh'],
    mesh: ['mesh', 'ink'], image: ['image'],
};
export const layerKinds = (datasetKind: string): LayerKind[] => kindsOf[datasetKind] ?? [];

/// A gesture without an end, as of a wheel, has ended after so long.
const settleMs = 160;
/// The longest view that a link may hold, bytes.
const mostLink = 1 << 20;

export class Model {
    /// What is opened by hand says the usual beside it; a view of a link, a file or a notebook what it says itself.
    view: View = create(ViewSchema, {annotations: usualAnnotations});
    /// The camera that is seen by; absent until the server has fitted one.
    camera: Camera | undefined;
    catalogue: Catalogue_Entry[] = [];
    /// The view is another's, whom we follow.
    following = false;
    /// A hand changed it here since it was loaded.
    touched = false;
    readonly manifests = new Map<string, Manifest>();
    /// Another dataset or kind of layer: controls are made anew.
    onLayers: () => void = () => {};
    /// Anything changed.
    onChange: () => void = () => {};

    private width = 0;
    private height = 0;
    private frame = 0;
    private moving = false;
    private settle = 0;

    constructor(private readonly server: Server) {}

    /// Something changed that was not asked for yet.
    get pending(): boolean {
        return this.frame !== 0;
    }

    get layer(): Layer | undefined {
        return this.view.layers[0];
    }

    get manifest(): Manifest | undefined {
        return this.layer && this.manifests.get(this.layer.dataset);
    }

    get steps(): number {
        const manifest = this.manifest;
        return manifest?.particles?.steps.length ?? manifest?.hybrid?.steps.length ?? 0;
    }

    /// Time of a step, s; undefined where it has none.
    timeOf(step: number): number | undefined {
        return this.manifest?.particles?.steps[step]?.time ?? this.manifest?.hybrid?.steps[step]?.time;
    }

    resize(width: number, height: number): void {
        if (width === this.width && height === this.height) return;
        this.width = width;
        this.height = height;
        this.ask(false);
    }

    get size(): {width: number, height: number} {
        return {width: this.width, height: this.height};
    }

    /// Shows a dataset alone.
    async open(entry: {name: string, kind: string}, kind?: LayerKind): Promise<void> {
        const drawn = kind ?? layerKinds(entry.kind)[0];
        if (!drawn) throw new Error(`a dataset of kind “${entry.kind}” is not drawn by itself`);
        this.following = false;
        this.view = create(ViewSchema, {
            layers: [{dataset: entry.name, kind: {case: drawn, value: {}}} as never],
            annotations: this.view.annotations, background: this.view.background,
        });
        this.camera = undefined;
        this.wanted();
        await this.describe();
    }

    /// Adds a dataset to what is shown.
    async add(entry: {name: string, kind: string}): Promise<void> {
        const kind = layerKinds(entry.kind)[0];
        if (!kind) throw new Error(`a dataset of kind “${entry.kind}” is not drawn by itself`);
        this.view.layers.push(create(LayerSchema, {dataset: entry.name, kind: {case: kind, value: {}} as never}));
        this.wanted();
        await this.describe();
    }

    remove(index: number): void {
        this.view.layers.splice(index, 1);
        this.wanted();
        this.onLayers();
    }

    /// Takes a whole view: of a link, a file, a notebook.
    async load(view: View): Promise<void> {
        this.following = false;
        this.view = clone(ViewSchema, view);
        this.camera = this.view.camera;
        this.touched = false;
        this.ask(false);
        await this.describe();
    }

    /// Takes the view of somebody else, whose pictures come by themselves.
    follow(view: View): void {
        this.view = clone(ViewSchema, view);
        this.camera = this.view.camera;
        this.onChange();
        void this.describe();
    }

    /// Goes on from what was followed.
    leave(): void {
        this.following = false;
        this.wanted();
        this.onLayers();
    }

    private async describe(): Promise<void> {
        this.onLayers();
        const unknown = this.view.layers.map((layer) => layer.dataset).filter((name) => !this.manifests.has(name));
        for (const name of new Set(unknown)) {
            const {manifest} = await this.server.describe(name);
            if (manifest) this.manifests.set(name, manifest);
        }
        if (unknown.length > 0) this.onLayers();
    }

    /// A live dataset has other steps than before: true if one that is known does.
    async learnSteps(): Promise<boolean> {
        const grown = this.catalogue.filter(({name, steps}) => {
            const particles = this.manifests.get(name)?.particles;
            return particles !== undefined && particles.steps.length !== steps;
        });
        for (const {name} of grown) {
            const {manifest} = await this.server.describe(name);
            if (manifest) this.manifests.set(name, manifest);
        }
        return grown.length > 0;
    }

    setStep(step: number, moving = false): void {
        for (const layer of this.view.layers) {
            const manifest = this.manifests.get(layer.dataset);
            const steps = manifest?.particles?.steps.length ?? manifest?.hybrid?.steps.length ?? 0;
            if (steps > 0) layer.step = Math.min(Math.max(step, 0), steps - 1);
            layer.towards = undefined;
        }
        this.wanted(moving);
    }

    setCamera(camera: Camera, moving = false): void {
        this.camera = camera;
        this.wanted(moving);
    }

    fit(): void {
        this.camera = undefined;
        this.wanted();
    }

    /// The view with its camera and size.
    whole(): View {
        const view = clone(ViewSchema, this.view);
        view.camera = this.camera;
        view.width = this.width;
        view.height = this.height;
        return view;
    }

    /// It changed: it is asked for. `moving`: the hand is still on it; after a while without it that ends by itself.
    wanted(moving = false): void {
        this.touched = true;
        this.ask(moving);
    }

    private ask(moving: boolean): void {
        this.moving = moving;
        clearTimeout(this.settle);
        if (moving) this.settle = window.setTimeout(() => this.ask(false), settleMs);
        if (!this.frame) this.frame = requestAnimationFrame(() => this.send());
        this.onChange();
    }

    private send(): void {
        this.frame = 0;
        if (this.following || this.width === 0 || this.height === 0 || this.view.layers.length === 0) return;
        this.server.setView({view: this.whole(), moving: this.moving});
    }

    /// The view as a link's fragment.
    async toFragment(): Promise<string> {
        const view = this.whole();
        view.width = 0;
        view.height = 0;
        const packed = await through(toBinary(ViewSchema, view), new CompressionStream('deflate-raw'));
        let text = '';
        for (const byte of packed) text += String.fromCharCode(byte);
        return 'v=' + btoa(text).replace(/\+/g, '-').replace(/\//g, '_').replace(/=+$/, '');
    }

    static async fromFragment(fragment: string): Promise<View | undefined> {
        const found = /^#?v=([\w-]+)$/.exec(fragment);
        if (!found) return undefined;
        const text = atob(found[1].replace(/-/g, '+').replace(/_/g, '/'));
        const bytes = Uint8Array.from(text, (char) => char.charCodeAt(0));
        return fromBinary(ViewSchema, await through(bytes, new DecompressionStream('deflate-raw')));
    }
}

async function through(bytes: Uint8Array, stream: CompressionStream | DecompressionStream): Promise<Uint8Array> {
    const reader = new Blob([bytes as BlobPart]).stream().pipeThrough(stream as ReadableWritablePair).getReader();
    const parts: Uint8Array[] = [];
    let size = 0;
    for (let part = await reader.read(); !part.done; part = await reader.read()) {
        size += part.value.length;
        if (size > mostLink) throw new Error('the view of this link is too long');
        parts.push(part.value);
    }
    const whole = new Uint8Array(size);
    let at = 0;
    for (const part of parts) {
        whole.set(part, at);
        at += part.length;
    }
    return whole;
}
