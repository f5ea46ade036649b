// SPDX-License-Identifier: GPL-3.0-or-later
//
// Small pictures of datasets, by a line of their own: a background session, whose pictures are made while nobody else
// waits for one (docs/PROTOCOL.md). One at a time.
import type {Catalogue_Entry, Frame} from './generated/protocol/mote_pb';
import {layerKinds} from './model';
import {Server} from './server';
import {Lossless} from './zstd';

export class Thumbnails {
    private server: Server | undefined;
    private lossless: Promise<Lossless> | undefined;
    private readonly waiting: {entry: Catalogue_Entry, place: HTMLCanvasElement}[] = [];
    private busy = false;
    private readonly seen = new IntersectionObserver((entries) => {
        for (const each of entries) {
            if (!each.isIntersecting) continue;
            this.seen.unobserve(each.target);
            const wanted = this.wanted.get(each.target);
            if (wanted) this.waiting.push({entry: wanted, place: each.target as HTMLCanvasElement});
        }
        void this.work();
    });
    private readonly wanted = new Map<Element, Catalogue_Entry>();

    /// Draws it once the canvas is seen.
    want(entry: Catalogue_Entry, place: HTMLCanvasElement): void {
        this.wanted.set(place, entry);
        this.seen.observe(place);
    }

    private async work(): Promise<void> {
        if (this.busy) return;
        this.busy = true;
        this.server ??= new Server(undefined, true);
        this.lossless ??= Lossless.load(new URL('zstd.wasm', document.baseURI));
        for (let next = this.waiting.shift(); next; next = this.waiting.shift()) {
            try {
                await this.draw(next.entry, next.place);
            } catch {
                // A dataset that cannot be drawn says so when it is opened.
            }
        }
        this.busy = false;
    }

    private async draw(entry: Catalogue_Entry, place: HTMLCanvasElement): Promise<void> {
        const {width, height} = place;
        const kind = layerKinds(entry.kind)[0];
        const step = Math.floor(entry.steps / 2);
        const {message, payload} = await this.server!.picture({
            view: {width, height, layers: [{dataset: entry.name, step, kind: {case: kind, value: {}} as never}]},
            finalOnly: true,
        });
        const frame = message.body.value as Frame;
        const image = (await this.lossless!).decode(payload, frame.width, frame.height);
        place.getContext('2d')!.putImageData(image, 0, 0);
    }
}
