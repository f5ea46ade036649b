// SPDX-License-Identifier: GPL-3.0-or-later
//
// Small pictures of datasets, by a line of their own: a server of minor 4 has them kept, an older one draws them for us in
// a background session, while nobody else waits for a picture (docs/PROTOCOL.md).
import type {Catalogue_Entry, Frame} from './generated/protocol/mote_pb';
import {layerKinds} from './model';
import {Server} from './server';
import {Lossless} from './zstd';

/// How many a server that keeps them is asked for at a time.
const mostAwaited = 6;

export class Thumbnails {
    private server: Server | undefined;
    private lossless: Promise<Lossless> | undefined;
    private readonly waiting: {entry: Catalogue_Entry, place: HTMLCanvasElement}[] = [];
    private working = 0;
    private readonly seen = new IntersectionObserver((entries) => {
        for (const each of entries) {
            if (!each.isIntersecting) continue;
            this.seen.unobserve(each.target);
            const wanted = this.wanted.get(each.target);
            if (wanted) this.waiting.push({entry: wanted, place: each.target as HTMLCanvasElement});
        }
        void this.begin();
    });
    private readonly wanted = new Map<Element, Catalogue_Entry>();

    /// Draws it once the canvas is seen.
    want(entry: Catalogue_Entry, place: HTMLCanvasElement): void {
        this.wanted.set(place, entry);
        this.seen.observe(place);
    }

    private async begin(): Promise<void> {
        this.server ??= new Server(undefined, true);
        await this.server.welcome;
        const most = this.server.minor >= 4 ? mostAwaited : 1;
        while (this.working < most && this.waiting.length > 0) void this.work();
    }

    private async work(): Promise<void> {
        ++this.working;
        for (let next = this.waiting.shift(); next; next = this.waiting.shift()) {
            try {
                await (this.server!.minor >= 4 ? this.fetch(next.entry, next.place) : this.draw(next.entry, next.place));
            } catch {
                // A dataset that cannot be drawn says so when it is opened.
            }
        }
        --this.working;
    }

    /// As large as the canvas needs, whose sides may be cut.
    private async fetch(entry: Catalogue_Entry, place: HTMLCanvasElement): Promise<void> {
        const {payload} = await this.server!.ask({case: 'getThumbnail', value: {dataset: entry.name}});
        const image = await createImageBitmap(new Blob([payload as BlobPart], {type: 'image/jpeg'}));
        const scale = Math.max(place.width / image.width, place.height / image.height);
        const [width, height] = [scale * image.width, scale * image.height];
        place.getContext('2d')!.drawImage(image, (place.width - width) / 2, (place.height - height) / 2, width, height);
    }

    private async draw(entry: Catalogue_Entry, place: HTMLCanvasElement): Promise<void> {
        this.lossless ??= Lossless.load(new URL('zstd.wasm', document.baseURI));
        const {width, height} = place;
        const kind = layerKinds(entry.kind)[0];
        const step = Math.floor(entry.steps / 2);
        const {message, payload} = await this.server!.picture({
            view: {width, height, layers: [{dataset: entry.name, step, kind: {case: kind, value: {}} as never}]},
            finalOnly: true,
        });
        const frame = message.body.value as Frame;
        const image = (await this.lossless).decode(payload, frame.width, frame.height);
        place.getContext('2d')!.putImageData(image, 0, 0);
    }
}
