// SPDX-License-Identifier: GPL-3.0-or-later
//
// Pictures: frames are put together of their pieces, decoded in their order, and drawn. A frame that a newer one has
// overtaken is not decoded, but for those of a stream, of which each needs the one before it. Runs in the worker.
import {Frame_Encoding, type Frame} from './generated/protocol/mote_pb';
import type {PictureInfo} from './messages';
import {Lossless} from './zstd';

/// The greatest picture that a server sends, bytes (docs/PROTOCOL.md, "The stream").
const mostPayload = 258 * 1024 * 1024;
/// A decoder that gave nothing for so long needs a key frame.
const stallMs = 1000;

export interface Arrived {
    frame: Frame;
    payload: Uint8Array;
    at: number;
}

/// What is drawn, and what becomes of the frames.
export interface PictureEvents {
    /// So many frames were shown or thrown away; a key frame is wanted.
    done(frames: number, keyWanted: boolean): void;
    shown(info: PictureInfo, source: Arrived): void;
    failed(why: string): void;
}

export const streamConfig: VideoDecoderConfig = {codec: 'avc1.640033', optimizeForLatency: true};

export async function decodesStream(): Promise<boolean> {
    if (typeof VideoDecoder === 'undefined') return false;
    try {
        return (await VideoDecoder.isConfigSupported(streamConfig)).supported === true;
    } catch {
        return false;
    }
}

/// Pieces of frames become frames.
export class Pieces {
    private open: {frame: Frame, payload: Uint8Array, filled: number} | undefined;

    reset(): void {
        this.open = undefined;
    }

    take(frame: Frame, payload: Uint8Array): Arrived | undefined {
        const total = Number(frame.payloadSize);
        const begin = Number(frame.payloadBegin);
        if (begin === 0 && total <= payload.length) {
            this.open = undefined;
            return {frame, payload, at: performance.now()};
        }
        if (begin === 0) {
            if (total > mostPayload) throw new Error('a picture is too large');
            this.open = {frame, payload: new Uint8Array(total), filled: 0};
        }
        const open = this.open;
        if (!open || open.frame.sequence !== frame.sequence || begin !== open.filled) return undefined;
        if (begin + payload.length > open.payload.length) throw new Error('a picture is longer than it said');
        open.payload.set(payload, begin);
        open.filled += payload.length;
        if (open.filled < open.payload.length) return undefined;
        this.open = undefined;
        return {frame: open.frame, payload: open.payload, at: performance.now()};
    }
}

export class Painter {
    private readonly context: OffscreenCanvasRenderingContext2D;
    private queue: Arrived[] = [];
    private busy = false;
    private decoder: VideoDecoder | undefined;
    private inDecoder: Arrived[] = [];
    private keyNeeded = true;
    private stall = 0;
    /// When the frame that is seen arrived: the stream's decoder may give an older one after it.
    private seen = 0;

    constructor(private readonly canvas: OffscreenCanvas, private readonly lossless: Promise<Lossless>,
                private readonly events: PictureEvents) {
        const context = canvas.getContext('2d', {alpha: false, colorSpace: 'srgb'});
        if (!context) throw new Error('this browser draws nothing');
        this.context = context;
    }

    /// A new connection: its stream begins anew.
    reset(): void {
        this.queue = [];
        this.dropDecoder();
    }

    push(arrived: Arrived): void {
        this.queue.push(arrived);
        if (!this.busy) void this.work();
    }

    grab(): ImageData | null {
        const {width, height} = this.canvas;
        return width && height ? this.context.getImageData(0, 0, width, height) : null;
    }

    private async work(): Promise<void> {
        this.busy = true;
        while (this.queue.length > 0) {
            this.skipOvertaken();
            const next = this.queue.shift()!;
            try {
                await this.decode(next);
            } catch (error) {
                this.events.failed(String(error));
                this.events.done(1, next.frame.encoding === Frame_Encoding.H264);
            }
        }
        this.busy = false;
    }

    private skipOvertaken(): void {
        const last = this.queue[this.queue.length - 1];
        const kept = this.queue.filter((each) => each === last || each.frame.encoding === Frame_Encoding.H264);
        if (kept.length < this.queue.length) this.events.done(this.queue.length - kept.length, false);
        this.queue = kept;
    }

    private async decode(arrived: Arrived): Promise<void> {
        const {frame, payload} = arrived;
        if (frame.encoding === Frame_Encoding.H264) return this.decodeStream(arrived);
        const begun = performance.now();
        if (frame.encoding === Frame_Encoding.ZSTD) {
            const image = (await this.lossless).decode(payload, frame.width, frame.height);
            this.resize(frame.width, frame.height);
            this.context.putImageData(image, 0, 0);
            this.tell(arrived, 'lossless', performance.now() - begun);
        } else {
            const bitmap = await createImageBitmap(new Blob([payload as BlobPart], {type: 'image/jpeg'}));
            this.resize(bitmap.width, bitmap.height);
            this.context.drawImage(bitmap, 0, 0);
            bitmap.close();
            this.tell(arrived, 'jpeg', performance.now() - begun);
        }
        this.events.done(1, false);
    }

    private decodeStream(arrived: Arrived): void {
        const {frame, payload} = arrived;
        if (this.keyNeeded && !frame.key) {
            this.events.done(1, true);
            return;
        }
        if (!this.decoder || this.decoder.state === 'closed') this.makeDecoder();
        this.keyNeeded = false;
        this.inDecoder.push(arrived);
        this.decoder!.decode(new EncodedVideoChunk({
            type: frame.key ? 'key' : 'delta', timestamp: Number(frame.sequence), data: payload}));
        clearTimeout(this.stall);
        this.stall = setTimeout(() => this.giveUpStream('the decoder stalled'), stallMs) as unknown as number;
    }

    private makeDecoder(): void {
        this.decoder = new VideoDecoder({
            output: (picture) => this.streamed(picture),
            error: (error) => this.giveUpStream(String(error)),
        });
        this.decoder.configure(streamConfig);
    }

    private streamed(picture: VideoFrame): void {
        clearTimeout(this.stall);
        let arrived = this.inDecoder.shift();
        while (arrived && Number(arrived.frame.sequence) < picture.timestamp) {
            this.events.done(1, false);
            arrived = this.inDecoder.shift();
        }
        if (!arrived) return picture.close();
        const {width, height} = arrived.frame;
        if (arrived.at >= this.seen) {
            this.resize(width, height);
            this.context.drawImage(picture, 0, 0, width, height, 0, 0, width, height);
            this.tell(arrived, 'h264', performance.now() - arrived.at);
        }
        picture.close();
        this.events.done(1, false);
    }

    private giveUpStream(why: string): void {
        const lost = this.inDecoder.length;
        this.dropDecoder();
        this.events.failed(why);
        this.events.done(lost, true);
    }

    private dropDecoder(): void {
        clearTimeout(this.stall);
        if (this.decoder && this.decoder.state !== 'closed') this.decoder.close();
        this.decoder = undefined;
        this.inDecoder = [];
        this.keyNeeded = true;
    }

    private resize(width: number, height: number): void {
        if (this.canvas.width !== width) this.canvas.width = width;
        if (this.canvas.height !== height) this.canvas.height = height;
    }

    private tell(arrived: Arrived, encoding: PictureInfo['encoding'], decode: number): void {
        const {frame} = arrived;
        this.seen = arrived.at;
        this.events.shown({
            viewId: Number(frame.viewId), width: frame.width, height: frame.height, final: frame.final, encoding,
            bytes: arrived.payload.length, latency: performance.now() - Number(frame.askedNs) / 1e6,
            server: frame.totalMs, decode, points: Number(frame.pointsDrawn), pointFraction: frame.pointFraction,
            link: frame.linkBytesPerSecond,
        }, arrived);
    }
}
