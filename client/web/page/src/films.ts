// SPDX-License-Identifier: GPL-3.0-or-later
//
// Films, which the server makes as jobs while nobody looks: a turn of the view, or its steps; and all jobs that there
// are, followed, cancelled, and what they made fetched.
import {create, type MessageInitShape} from '@bufbuild/protobuf';
import {amount, download, h, iconButton, setChildren, tell} from './dom';
import {JobRequestSchema, JobStatus_State, type FilmPiece, type JobStatus, type MoveSchema} from
    './generated/protocol/mote_pb';
import type {Model} from './model';
import type {Server} from './server';

const stateNames: Record<JobStatus_State, string> = {
    [JobStatus_State.STATE_UNSPECIFIED]: '', [JobStatus_State.QUEUED]: 'waits', [JobStatus_State.RUNNING]: 'runs',
    [JobStatus_State.SUCCEEDED]: 'done', [JobStatus_State.FAILED]: 'failed', [JobStatus_State.CANCELLED]: 'cancelled',
};
const running = ({state}: JobStatus) => state === JobStatus_State.RUNNING || state === JobStatus_State.QUEUED;
/// The longest file that a page keeps in memory to hand it over, bytes.
const mostDownload = 2 ** 31;

/// The row of a job. Its buttons stay the same while its state does, so that a click meets the one it began on.
interface Row {
    job: JobStatus;
    readonly place: HTMLElement;
    readonly progress: HTMLProgressElement;
    readonly words: HTMLElement;
}

export class FilmPanel {
    private readonly rows = new Map<string, Row>();
    private readonly list = h('ul', {class: 'jobs'});
    private readonly form = h('section', {class: 'section', 'aria-label': 'New film'});
    private watching = false;

    constructor(private readonly place: HTMLElement, private readonly server: Server, private readonly model: Model) {
        server.onJob = (job) => this.show(job);
        place.append(this.form, h('section', {class: 'section', 'aria-label': 'Jobs'},
                                  h('h2', {}, h('span', {}, 'Jobs')), this.list));
        this.drawJobs();
    }

    /// The line is a new one: jobs are told of only to those who ask.
    lineIsNew(): void {
        this.watching = false;
        if (!this.place.hidden) this.draw();
    }

    draw(): void {
        if (!this.watching) {
            this.watching = true;
            this.server.ask({case: 'watchJobs', value: {}}).then(({message}) => {
                if (message.body.case === 'jobs') message.body.value.jobs.forEach((job) => this.server.onJob(job));
            }, () => { this.watching = false; });
        }
        this.drawForm();
    }

    private drawForm(): void {
        const choice = (id: string, label: string, options: [string, string][]) => {
            const select = h('select', {id}, ...options.map(([value, text]) => h('option', {value}, text)));
            return [select, h('div', {class: 'row'}, h('label', {for: id}, label), select)] as const;
        };
        const moves: [string, string][] = [['turn', 'one turn']];
        if (this.model.steps > 1) moves.unshift(['steps', 'all steps'], ['both', 'all steps, turning']);
        const [move, moveRow] = choice('film-move', 'Shows', moves);
        const [size, sizeRow] = choice('film-size', 'Size', [['1280x720', '1280 × 720'], ['1920x1080', '1920 × 1080'],
                                                              ['3840x2160', '3840 × 2160'], ['640x360', '640 × 360']]);
        const [kind, kindRow] = choice('film-kind', 'File', [['mp4', 'MP4'], ['mp4 full', 'MP4, full colour'],
                                                             ['webm', 'WebM'], ['gif', 'GIF']]);
        const seconds = h('input', {type: 'number', id: 'film-seconds', min: '0.1', max: '600', step: 'any', value: '8'});
        const make = h('button', {type: 'button', class: 'button first', disabled: !this.model.layer, onclick: () =>
            this.make(move.value, size.value, kind.value, Number(seconds.value))}, 'Make the film');
        this.form.replaceChildren(h('h2', {}, h('span', {}, 'New film')), moveRow,
                                  h('div', {class: 'row'}, h('label', {for: 'film-seconds'}, 'Seconds'), seconds),
                                  sizeRow, kindRow, h('div', {class: 'buttons'}, make));
    }

    private async make(move: string, size: string, kind: string, seconds: number): Promise<void> {
        if (!this.model.camera || !(seconds > 0)) return tell('A film needs a picture to begin with, and a time.', true);
        const [width, height] = size.split('x').map(Number);
        const [video, chroma = ''] = kind.split(' ');  // full: single points keep their colours; else it plays everywhere
        const whole: MessageInitShape<typeof MoveSchema> = {seconds};
        if (move !== 'steps') whole.turn = {degrees: 360, axis: []};
        if (move !== 'turn') whole.playSteps = {from: 0, to: this.model.steps - 1, dataset: ''};
        const view = Object.assign(this.model.whole(), {width, height});
        const job = create(JobRequestSchema, {
            title: `${view.layers[0].dataset}, ${move}`,
            kind: {case: 'film', value: {script: {view, moves: [whole], fps: 30}, format: 'png', video, chroma}},
        });
        try {
            const {message} = await this.server.ask({case: 'submitJob', value: {job}}, undefined, true);
            if (message.body.case === 'job') this.server.onJob(message.body.value);
        } catch (error) {
            tell((error as Error).message, true);
        }
    }

    private show(job: JobStatus): void {
        const before = this.rows.get(job.id);
        const row = before?.job.state === job.state ? before : this.row(job);
        this.rows.set(job.id, row);
        row.job = job;
        row.progress.value = job.progress;
        row.words.textContent = job.error || job.waitsFor ||
            [stateNames[job.state], running(job) ? job.phase : ''].filter(Boolean).join(': ');
        if (!before) this.drawJobs();
        else if (row !== before) before.place.replaceWith(row.place);
    }

    private drawJobs(): void {
        const rows = [...this.rows.values()].sort((a, b) => Number(b.job.createdMs - a.job.createdMs));
        setChildren(this.list, rows.length > 0 ? rows.map(({place}) => place)
                                               : [h('li', {class: 'note'}, 'There are none.')]);
    }

    private row(job: JobStatus): Row {
        const name = job.request?.title || job.request?.output || job.id;
        const film = job.request?.kind.case === 'film' ? job.request.kind.value : undefined;
        const actions: HTMLElement[] = [];
        if (running(job))
            actions.push(iconButton('close', `Cancel ${name}`, () => this.act({case: 'cancelJob', value: {id: job.id}})));
        if (film?.video && job.state === JobStatus_State.SUCCEEDED)
            actions.push(iconButton('save', `Save ${name}`, () => void this.fetch(job)));
        if (job.state === JobStatus_State.FAILED)
            actions.push(iconButton('reset', `Try ${name} again`, () => this.act({case: 'retryJob', value: {id: job.id}})));
        const progress = h('progress', {max: 1, 'aria-label': `Progress of ${name}`});
        const words = h('p', {class: 'note'});
        const place = h('li', {}, h('div', {class: 'head'}, h('b', {title: name}, name), ...actions),
                        running(job) && progress, words);
        return {job, place, progress, words};
    }

    private act(body: Parameters<Server['ask']>[0]): void {
        this.server.ask(body, undefined, true).then(({message}) => {
            if (message.body.case === 'job') this.server.onJob(message.body.value);
        }, (error) => tell(error.message, true));
    }

    private async fetch(job: JobStatus): Promise<void> {
        const parts: Uint8Array[] = [];
        let begin = 0;
        let name = 'film';
        try {
            for (let size = Infinity; begin < size;) {
                const {message, payload} = await this.server.ask(
                    {case: 'fetchFilm', value: {id: job.id, begin: BigInt(begin)}});
                const piece = message.body.value as FilmPiece;
                size = Number(piece.size);
                if (size > mostDownload) throw new Error(`the file has ${amount(size)} bytes: fetch it with mote-frames --fetch`);
                if (payload.length === 0) break;
                parts.push(payload);
                begin += payload.length;
                name = piece.name;
            }
            download(name, parts as BlobPart[], 'application/octet-stream');
        } catch (error) {
            tell((error as Error).message, true);
        }
    }
}
