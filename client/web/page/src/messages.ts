// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the page and its worker tell each other. The worker holds the line and draws; the page wants and shows.

/// What is wanted of the line's worker.
export type ToWorker =
    | {kind: 'open', url: string, canvas?: OffscreenCanvas, background: boolean}
    /// A SetView, encoded, without its id; it replaces the view before it.
    | {kind: 'view', bytes: Uint8Array}
    /// A ClientMessage, encoded, without its request number. `once`: not to be asked again where the line broke.
    | {kind: 'ask', id: number, bytes: Uint8Array, once: boolean}
    | {kind: 'grab', id: number}
    | {kind: 'retry'};

/// How a picture came about.
export interface PictureInfo {
    viewId: number;
    width: number;
    height: number;
    final: boolean;
    encoding: 'lossless' | 'jpeg' | 'h264';
    bytes: number;
    /// From when the view was wanted until the picture was drawn, ms; the server's part of it; decoding.
    latency: number;
    server: number;
    decode: number;
    points: number;
    pointFraction: number;
    /// Bytes a second, as the server measured it; 0: not yet.
    link: number;
    /// A Camera, encoded: that was fitted to a view without one.
    camera?: Uint8Array;
}

export type LineState = 'connecting' | 'connected' | 'refused';

export type FromWorker =
    | {kind: 'state', state: LineState, why: string}
    | {kind: 'role', role: 'owner' | 'follower'}
    | {kind: 'welcome', server: string, device: string, minor: number}
    | {kind: 'picture', info: PictureInfo}
    /// A ServerMessage, encoded, and its payload. `id`: of the question that it answers; 0: it came unasked.
    | {kind: 'message', id: number, bytes: Uint8Array, payload: Uint8Array}
    | {kind: 'grabbed', id: number, picture: ImageData | null}
    | {kind: 'lost', id: number, why: string};
