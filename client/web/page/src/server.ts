// SPDX-License-Identifier: GPL-3.0-or-later
//
// Server: the page's end of the worker that holds the line. Questions are promises; views and pictures are states.
import {create, fromBinary, toBinary, type MessageInitShape} from '@bufbuild/protobuf';
import {ClientMessageSchema, ServerMessageSchema, SetViewSchema, type Answer, type Catalogue, type Description,
        type Followed, type JobStatus, type Query, type ServerMessage, type SetView} from './generated/protocol/mote_pb';
import type {FromWorker, LineState, PictureInfo, ToWorker} from './messages';

export type Body = MessageInitShape<typeof ClientMessageSchema>['body'];

export interface Reply {
    message: ServerMessage;
    payload: Uint8Array;
}

export class ServerError extends Error {
    constructor(readonly code: string, readonly where: string, message: string) {
        super(where ? `${where}: ${message}` : message);
    }
}

interface Waiting {
    take(reply: Reply): boolean;
    fail(error: Error): void;
}

export class Server {
    onState: (state: LineState, why: string) => void = () => {};
    onRole: (role: 'owner' | 'follower') => void = () => {};
    onWelcome: (server: string, device: string) => void = () => {};
    onPicture: (info: PictureInfo) => void = () => {};
    onCatalogue: (catalogue: Catalogue) => void = () => {};
    onJob: (job: JobStatus) => void = () => {};
    onFollowed: (followed: Followed) => void = () => {};
    /// Of views, and of what belongs to no question.
    onFailure: (error: ServerError) => void = () => {};

    private readonly worker = new Worker(new URL('worker.js', document.baseURI), {type: 'module'});
    private readonly waiting = new Map<number, Waiting>();
    private readonly grabs = new Map<number, (picture: ImageData | null) => void>();
    private next = 1;
    /// Which minor version of the protocol the server speaks; 0: not known yet.
    minor = 0;
    private welcomed: () => void = () => {};
    /// Once it is known.
    readonly welcome = new Promise<void>((resolve) => {
        this.welcomed = resolve;
    });
    /// The id of the view that was wanted last: pictures carry it.
    viewId = 0;

    constructor(canvas?: HTMLCanvasElement, background = false) {
        this.worker.onmessage = (event: MessageEvent<FromWorker>) => this.heard(event.data);
        this.worker.onerror = (event) => this.onState('refused', event.message || 'the worker does not start');
        const url = new URL('ws', document.baseURI);
        url.protocol = url.protocol.replace('http', 'ws');
        const place = canvas?.transferControlToOffscreen();
        this.post({kind: 'open', url: url.href, canvas: place, background}, place ? [place] : []);
    }

    setView(view: MessageInitShape<typeof SetViewSchema>): void {
        ++this.viewId;
        this.post({kind: 'view', bytes: toBinary(SetViewSchema, create(SetViewSchema, view))});
    }

    /// The answer's message; `take` is told of each one and says whether more come.
    ask(body: Body, take: (reply: Reply) => boolean = () => false, once = false): Promise<Reply> {
        const id = this.next++;
        return new Promise((resolve, reject) => {
            this.waiting.set(id, {
                take: (reply) => {
                    const more = take(reply);
                    if (!more) resolve(reply);
                    return more;
                },
                fail: reject,
            });
            this.post({kind: 'ask', id, bytes: toBinary(ClientMessageSchema, create(ClientMessageSchema, {body})), once});
        });
    }

    async listDatasets(): Promise<Catalogue> {
        return (await this.ask({case: 'listDatasets', value: {}})).message.body.value as Catalogue;
    }

    async describe(dataset: string): Promise<Description> {
        return (await this.ask({case: 'describe', value: {dataset}})).message.body.value as Description;
    }

    /// All answers of a query, one a step.
    async query(query: MessageInitShape<typeof import('./generated/protocol/mote_pb').QuerySchema> | Query):
        Promise<{answer: Answer, payload: Uint8Array}[]> {
        const answers: {answer: Answer, payload: Uint8Array}[] = [];
        await this.ask({case: 'query', value: query}, ({message, payload}) => {
            const answer = message.body.value as Answer;
            answers.push({answer, payload});
            return !answer.last;
        });
        return answers;
    }

    /// One picture of a view, of a line without a canvas.
    async picture(view: MessageInitShape<typeof SetViewSchema>): Promise<Reply> {
        return this.ask({case: 'setView', value: view as SetView});
    }

    /// The pixels that are shown now.
    grab(): Promise<ImageData | null> {
        const id = this.next++;
        return new Promise((resolve) => {
            this.grabs.set(id, resolve);
            this.post({kind: 'grab', id});
        });
    }

    retry(): void {
        this.post({kind: 'retry'});
    }

    private post(message: ToWorker, transfer: Transferable[] = []): void {
        this.worker.postMessage(message, transfer);
    }

    private heard(message: FromWorker): void {
        switch (message.kind) {
            case 'state': return this.onState(message.state, message.why);
            case 'role': return this.onRole(message.role);
            case 'welcome':
                this.minor = message.minor;
                this.welcomed();
                return this.onWelcome(message.server, message.device);
            case 'picture': return this.onPicture(message.info);
            case 'grabbed':
                this.grabs.get(message.id)?.(message.picture);
                this.grabs.delete(message.id);
                return;
            case 'lost':
                this.waiting.get(message.id)?.fail(new ServerError('internal', '', message.why));
                this.waiting.delete(message.id);
                return;
            case 'message': return this.answered(message.id, fromBinary(ServerMessageSchema, message.bytes),
                                                 message.payload);
        }
    }

    private answered(id: number, message: ServerMessage, payload: Uint8Array): void {
        const {body} = message;
        const waiting = this.waiting.get(id);
        if (body.case === 'failure') {
            const error = new ServerError(body.value.code, body.value.where, body.value.message);
            if (!waiting) return this.onFailure(error);
            this.waiting.delete(id);
            return waiting.fail(error);
        }
        if (waiting) {
            if (!waiting.take({message, payload})) this.waiting.delete(id);
            return;
        }
        if (body.case === 'catalogue') this.onCatalogue(body.value);
        if (body.case === 'job') this.onJob(body.value);
        if (body.case === 'jobs') body.value.jobs.forEach((job) => this.onJob(job));
        if (body.case === 'followed') this.onFollowed(body.value);
    }
}
