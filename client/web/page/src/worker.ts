// SPDX-License-Identifier: GPL-3.0-or-later
//
// The worker: the line to the server and its pictures. It says hello, answers pings, says what it has received before
// it decodes anything, opens a line again that broke, and asks again what was not answered (docs/PROTOCOL.md).
import {create, fromBinary, toBinary, type MessageInitShape} from '@bufbuild/protobuf';
import {CameraSchema, ClientMessageSchema, Frame_Encoding, ServerMessageSchema, SetViewSchema, type Frame,
        type ServerMessage, type SetView, type Welcome} from './generated/protocol/mote_pb';
import type {FromWorker, LineState, PictureInfo, ToWorker} from './messages';
import {Painter, Pieces, decodesStream, type Arrived} from './pictures';
import {Lossless} from './zstd';

const minor = 4;
const firstPause = 200;
const longestPause = 5000;

const say = (message: FromWorker, transfer: Transferable[] = []) => postMessage(message, {transfer});

interface Question {
    bytes: Uint8Array;
    once: boolean;
    sent: boolean;
}

class Line {
    private socket: WebSocket | undefined;
    private welcomed = false;
    private opened = false;
    private resume = '';
    private pause = firstPause;
    private received = 0;
    private viewId = 0n;
    private view: SetView | undefined;
    private readonly questions = new Map<number, Question>();
    private readonly pieces = new Pieces();
    private readonly painter: Painter | undefined;
    private timer = 0;

    constructor(private readonly url: string, canvas: OffscreenCanvas | undefined, private readonly background: boolean,
                private readonly streams: boolean) {
        const lossless = Lossless.load(new URL('zstd.wasm', location.href));
        lossless.catch((error) => this.tellState('refused', `the decoder cannot be loaded: ${error}`));
        if (canvas) {
            this.painter = new Painter(canvas, lossless, {
                done: (frames, keyWanted) => this.send({case: 'credit', value: {frames, keyWanted}}),
                shown: (info, arrived) => this.tellPicture(info, arrived),
                failed: (why) => console.warn(why),
            });
        }
        this.open();
    }

    /// Another view is wanted; that before it is not any more.
    setView(bytes: Uint8Array): void {
        this.view = fromBinary(SetViewSchema, bytes);
        this.view.askedNs = BigInt(Math.round(performance.now() * 1e6));
        this.view.viewId = ++this.viewId;
        if (this.welcomed) this.sendView();
    }

    ask(id: number, bytes: Uint8Array, once: boolean): void {
        const question = {bytes, once, sent: false};
        this.questions.set(id, question);
        if (this.welcomed) this.sendQuestion(id, question);
    }

    grab(id: number): void {
        say({kind: 'grabbed', id, picture: this.painter?.grab() ?? null});
    }

    retry(): void {
        if (this.socket && this.socket.readyState <= WebSocket.OPEN) return;
        clearTimeout(this.timer);
        this.open();
    }

    private open(): void {
        this.welcomed = false;
        this.opened = false;
        this.received = 0;
        this.pieces.reset();
        this.painter?.reset();
        this.tellState('connecting', '');
        const socket = new WebSocket(this.url, ['mote.1']);
        socket.binaryType = 'arraybuffer';
        socket.onopen = () => {
            this.opened = true;
            this.hello();
        };
        socket.onmessage = (event) => this.heard(event.data);
        socket.onclose = (event) => {
            if (socket === this.socket) void this.closed(event);
        };
        this.socket = socket;
    }

    private hello(): void {
        this.send({case: 'hello', value: {
            client: 'mote-web page', minor, decodes: this.streams ? [Frame_Encoding.H264] : [], receipts: true,
            background: this.background, resume: this.resume,
        }});
    }

    private async closed(event: CloseEvent): Promise<void> {
        this.welcomed = false;
        for (const [id, question] of this.questions) {
            if (!question.once || !question.sent) continue;
            this.questions.delete(id);
            say({kind: 'lost', id, why: 'the line broke before the answer came'});
        }
        if (event.code === 1008) return this.tellState('refused', event.reason);
        if (!this.opened && await this.isForbidden())
            return this.tellState('refused', 'This page has no leave any more: open the link that mote-web prints.');
        this.tellState('connecting', event.reason);
        this.timer = setTimeout(() => this.open(), this.pause) as unknown as number;
        this.pause = Math.min(2 * this.pause, longestPause);
    }

    /// A WebSocket does not tell why it was refused.
    private async isForbidden(): Promise<boolean> {
        try {
            return (await fetch(new URL('.', location.href), {method: 'HEAD', cache: 'no-store'})).status === 403;
        } catch {
            return false;
        }
    }

    private heard(data: ArrayBuffer | string): void {
        if (typeof data === 'string') {
            say({kind: 'role', role: JSON.parse(data).role});
            return;
        }
        const head = new DataView(data);
        const size = head.getUint32(0, true);
        const bytes = new Uint8Array(data, 8, size);
        const payload = new Uint8Array(data, 8 + size);
        const message = fromBinary(ServerMessageSchema, bytes);
        switch (message.body.case) {
            case 'frame': return this.takeFrame(message.body.value, payload);
            case 'welcome': return this.takeWelcome(message.body.value);
            case 'ping': return this.send({case: 'pong', value: {sentNs: message.body.value.sentNs}});
            default: return this.takeAnswer(message, bytes, payload);
        }
    }

    private takeWelcome(welcome: Welcome): void {
        this.welcomed = true;
        this.pause = firstPause;
        this.resume = welcome.resume;
        this.tellState('connected', '');
        say({kind: 'welcome', server: welcome.server, device: welcome.device, minor: welcome.minor});
        for (const [id, question] of this.questions) this.sendQuestion(id, question);
        if (this.view) this.sendView();
    }

    private takeFrame(frame: Frame, payload: Uint8Array): void {
        this.received += payload.length;
        this.send({case: 'credit', value: {receivedBytes: BigInt(this.received)}});
        const whole = this.pieces.take(frame, payload);
        if (!whole) return;
        if (this.painter) return this.painter.push(whole);
        this.send({case: 'credit', value: {frames: 1}});
        const message = create(ServerMessageSchema, {replyTo: whole.frame.viewId, body: {case: 'frame', value: whole.frame}});
        this.takeAnswer(message, toBinary(ServerMessageSchema, message), whole.payload);
    }

    private takeAnswer(message: ServerMessage, bytes: Uint8Array, payload: Uint8Array): void {
        const id = Number(message.replyTo);
        const many = message.body.case === 'answer' && !message.body.value.last;
        if (!many && id) this.questions.delete(id);
        // The page takes them out of our buffer.
        say({kind: 'message', id, bytes: bytes.slice(), payload: payload.slice()});
    }

    private sendQuestion(id: number, question: Question): void {
        const message = fromBinary(ClientMessageSchema, question.bytes);
        message.request = BigInt(id);
        if (message.body.case === 'setView') message.body.value.viewId = BigInt(id);
        question.sent = true;
        this.sendBytes(toBinary(ClientMessageSchema, message));
    }

    private sendView(): void {
        this.send({case: 'setView', value: this.view!});
    }

    private send(body: MessageInitShape<typeof ClientMessageSchema>['body']): void {
        this.sendBytes(toBinary(ClientMessageSchema, create(ClientMessageSchema, {body})));
    }

    private sendBytes(message: Uint8Array): void {
        if (this.socket?.readyState !== WebSocket.OPEN) return;
        const bytes = new Uint8Array(8 + message.length);
        new DataView(bytes.buffer).setUint32(0, message.length, true);
        bytes.set(message, 8);
        this.socket.send(bytes);
    }

    private tellPicture(info: PictureInfo, arrived: Arrived): void {
        if (arrived.frame.camera) info.camera = toBinary(CameraSchema, arrived.frame.camera);
        say({kind: 'picture', info});
    }

    private tellState(state: LineState, why: string): void {
        say({kind: 'state', state, why});
    }
}

let line: Line | undefined;
const early: ToWorker[] = [];

function obey(message: ToWorker): void {
    switch (message.kind) {
        case 'view': return line!.setView(message.bytes);
        case 'ask': return line!.ask(message.id, message.bytes, message.once);
        case 'grab': return line!.grab(message.id);
        case 'retry': return line!.retry();
    }
}

onmessage = async (event: MessageEvent<ToWorker>) => {
    const message = event.data;
    if (message.kind === 'open') {
        line = new Line(message.url, message.canvas, message.background, await decodesStream());
        early.splice(0).forEach(obey);
    } else if (line) {
        obey(message);
    } else {
        early.push(message);
    }
};
