// SPDX-License-Identifier: GPL-3.0-or-later
//
// The page: puts its parts together and lets them know of each other.
import {fromBinary, fromJson, toJsonString} from '@bufbuild/protobuf';
import {toggleProjection} from './camera';
import {CatalogueList} from './catalogue';
import {amount, copyText, download, h, icon, iconButton, tell} from './dom';
import {CameraSchema, ViewSchema} from './generated/protocol/mote_pb';
import {FilmPanel} from './films';
import {Gestures} from './gestures';
import {LayerPanels} from './layers';
import type {PictureInfo} from './messages';
import {layerKinds, Model} from './model';
import {NumbersPanel} from './numbers';
import {Room} from './room';
import {SelectionPanel} from './selection';
import {Server} from './server';
import {tabs} from './tabs';
import {Thumbnails} from './thumbnails';
import {TimeBar} from './time';

const place = (id: string) => document.getElementById(id)!;
const byteText = (bytes: number) => bytes < 1e6 ? `${Math.round(bytes / 1e3)} kB` : `${(bytes / 1e6).toFixed(1)} MB`;

class Page {
    private readonly server = new Server(place('picture') as HTMLCanvasElement);
    private readonly model = new Model(this.server);
    private readonly catalogue = new CatalogueList(place('data'), this.model);
    private readonly gestures = new Gestures(place('stage'), this.model);
    private readonly looks = h('div');
    private readonly numbered = h('div');
    private readonly filmed = h('div');
    private readonly panels = new LayerPanels(this.looks, this.model);
    private readonly numbers = new NumbersPanel(this.numbered, this.server, this.model,
        new SelectionPanel(this.model, this.gestures, place('stage'), place('marks') as HTMLCanvasElement));
    private readonly films = new FilmPanel(this.filmed, this.server, this.model);
    private readonly time = new TimeBar(place('time'), this.model);
    private last: PictureInfo | undefined;
    private begun = false;
    private room: Room | undefined;
    private role: 'owner' | 'follower' = 'owner';

    constructor() {
        // The token was good once, and is of no use in anybody's history.
        if (location.search) history.replaceState(null, '', location.pathname + location.hash);
        const thumbnails = new Thumbnails();
        this.catalogue.onThumbnail = (entry, canvas) => thumbnails.want(entry, canvas);
        this.panels.onSave = () => this.saveView();
        this.panels.onOpen = (file) => void this.openView(file);
        this.gestures.onTap = (x, y) => void this.numbers.pick(x, y);
        tabs(place('look'), [
            {name: 'Look', panel: this.looks, shown: () => {}},
            {name: 'Numbers', panel: this.numbered, shown: () => this.numbers.draw()},
            {name: 'Films', panel: this.filmed, shown: () => this.films.draw()},
        ]);
        this.tools();
        this.sides();
        this.watchSize();
        this.listen();
        document.addEventListener('keydown', (event) => this.key(event));
        addEventListener('hashchange', () => void this.loadFragment());
        addEventListener('online', () => this.server.retry());
        document.addEventListener('visibilitychange', () => document.hidden || this.server.retry());
        this.showEmpty();
    }

    private listen(): void {
        const {server, model} = this;
        model.onLayers = () => {
            this.panels.draw();
            this.numbers.draw();
            if (!this.filmed.hidden) this.films.draw();
            this.catalogue.mark();
            this.time.draw();
            this.showTitle();
        };
        model.onChange = () => {
            place('stage').dataset.final = 'false';
            this.time.draw();
            this.numbers.refresh();
            this.showEmpty();
            this.showFollowing();
        };
        server.onState = (state, why) => {
            place('status').classList.toggle('waiting', state !== 'connected');
            if (state === 'connecting') place('status').textContent = why ? `Connecting again: ${why}` : 'Connecting';
            if (state === 'connected') this.showStatus();
            if (state === 'refused') {
                place('status').textContent = why;
                tell(why, true);
            }
        };
        server.onWelcome = () => void this.begin();
        server.onRole = (role) => {
            this.role = role;
            document.body.classList.toggle('follower', role === 'follower');
            if (role === 'follower' && !this.begun && !location.hash) model.following = true;
        };
        server.onFollowed = (followed) => {
            if (!model.following) return;
            if (followed.view?.view) model.follow(followed.view.view);
            else tell('Nobody shows anything yet.');
        };
        server.onCatalogue = (catalogue) => {
            model.catalogue = catalogue.datasets;
            this.catalogue.draw();
            model.learnSteps().then((grown) => grown && this.time.draw(), (error) => tell(error.message, true));
        };
        server.onFailure = (error) => {
            place('status').textContent = 'Not drawn';
            tell(error.message, true);
        };
        server.onPicture = (info) => this.shown(info);
    }

    private async begin(): Promise<void> {
        this.model.catalogue = (await this.server.listDatasets()).datasets;
        this.catalogue.draw();
        this.films.lineIsNew();
        this.showEmpty();
        if (this.model.following) this.follow();
        if (this.begun) return;
        this.begun = true;
        const room = Room.nameOf(location.hash);
        if (room) this.room = new Room(room, (view) => this.model.load(view).catch((error) => tell(error.message, true)));
        else await this.loadFragment();
        await this.openOnlyOne();
    }

    /// Where there is nothing to choose from, nobody is asked to choose.
    private async openOnlyOne(): Promise<void> {
        const {catalogue, view, following} = this.model;
        if (this.room || following || this.role === 'follower' || view.layers.length > 0 || catalogue.length !== 1) return;
        if (layerKinds(catalogue[0].kind).length > 0)
            await this.model.open(catalogue[0]).catch((error) => tell(String(error.message), true));
    }

    /// Shows what whoever changed their view last sees, until something is chosen here.
    private follow(): void {
        this.model.following = true;
        this.model.onChange();
        this.server.ask({case: 'follow', value: {}}).then(({message}) => {
            if (message.body.case === 'followed') this.server.onFollowed(message.body.value);
        }, (error) => tell(error.message, true));
    }

    private async loadFragment(): Promise<void> {
        try {
            const view = await Model.fromFragment(location.hash);
            if (view) await this.model.load(view);
        } catch (error) {
            tell(`This link holds no view: ${(error as Error).message}`, true);
        }
    }

    private shown(info: PictureInfo): void {
        this.last = info;
        // Whoever frames the page, or measures it, hears of each picture.
        place('stage').dispatchEvent(new CustomEvent('picture', {detail: info}));
        if (info.camera && !this.model.camera && !this.model.following) {
            this.model.camera = fromBinary(CameraSchema, info.camera);
            this.panels.draw();
        }
        this.time.shown();
        this.showStatus();
        const latest = this.model.following || (info.viewId === this.server.viewId && !this.model.pending);
        place('stage').dataset.final = String(info.final && latest);
        if (info.final && latest) void this.keepInAddress();
    }

    /// A reload shows the same again.
    private async keepInAddress(): Promise<void> {
        if (this.model.following) return;
        if (this.room) return this.room.put(this.model.whole(), this.model.touched);
        history.replaceState(null, '', `${location.pathname}#${await this.model.toFragment()}`);
    }

    private showStatus(): void {
        const info = this.last;
        if (!info) {
            place('status').textContent = '';
            return;
        }
        const quality = info.final ? 'Exact' : info.encoding === 'lossless' ? 'Preview' : 'Preview, compressed';
        const points = info.points > 0 ? ` · ${amount(info.points)} points` : '';
        place('status').textContent =
            `${quality}${points} · ${Math.round(info.latency)} ms · ${byteText(info.bytes)}`;
    }

    private showTitle(): void {
        const names = this.model.view.layers.map((layer) => {
            const title = this.model.manifests.get(layer.dataset)?.title;
            return title || layer.dataset;
        });
        place('title').textContent = names.join(' + ');
        document.title = names.length > 0 ? `${names.join(' + ')} – Mote` : 'Mote';
    }

    private showFollowing(): void {
        const {following} = this.model;
        const chip = place('following');
        const state = `${this.role}, ${following}`;
        if (chip.dataset.state === state) return;
        chip.dataset.state = state;
        chip.hidden = this.role === 'owner';
        document.body.classList.toggle('following', following);
        chip.replaceChildren(following ? 'Following' : 'On your own', h('button', {type: 'button', class: 'button', onclick: () =>
            following ? this.model.leave() : this.follow()}, following ? 'Look around yourself' : 'Follow'));
    }

    private showEmpty(): void {
        const empty = place('empty');
        empty.hidden = this.model.view.layers.length > 0 || this.model.following;
        if (!empty.hidden)
            empty.replaceChildren(h('h2', {}, 'Choose a dataset'),
                                  h('p', {}, 'The server draws it; only pictures are sent here.'));
    }

    private watchSize(): void {
        const stage = place('stage');
        const apply = (width: number, height: number) => this.model.resize(Math.max(1, width), Math.max(1, height));
        const observer = new ResizeObserver(([entry]) => {
            const exact = entry.devicePixelContentBoxSize?.[0];
            if (exact) return apply(exact.inlineSize, exact.blockSize);
            return apply(Math.round(stage.clientWidth * devicePixelRatio), Math.round(stage.clientHeight * devicePixelRatio));
        });
        try {
            observer.observe(stage, {box: 'device-pixel-content-box'});
        } catch {
            observer.observe(stage);
        }
    }

    private tools(): void {
        const wide = {class: 'icon-button wide'};
        place('tools').append(
            iconButton('fit', 'Fit (F)', () => this.model.fit()),
            iconButton('cube', 'Perspective or parallel (O)', () => this.toggleProjection(), wide),
            iconButton('save', 'Save the picture (S)', () => void this.savePicture(), wide),
            iconButton('link', 'Copy a link to this view (L)', () => void this.copyLink()),
            iconButton('share', 'Copy a link for followers, who look and change nothing', () => void this.share(), {class: 'icon-button wide owners'}),
            iconButton('theme', 'Light or dark (T)', () => this.toggleTheme(), wide),
            iconButton('help', 'Keys and gestures (?)', () => this.showHelp(), wide));
    }

    private sides(): void {
        const narrow = () => matchMedia('(max-width: 860px)').matches;
        const set = (side: 'data' | 'look', shown: boolean) => {
            document.body.classList.toggle(`no-${side}`, !shown);
            place(`show-${side}`).setAttribute('aria-expanded', String(shown));
        };
        const toggle = (side: 'data' | 'look') => {
            const shown = document.body.classList.contains(`no-${side}`);
            set(side, shown);
            if (shown && narrow()) set(side === 'data' ? 'look' : 'data', false);
        };
        for (const [side, name, label] of [['data', 'list', 'Datasets'], ['look', 'sliders', 'Look and numbers']] as const) {
            place(`show-${side}`).append(icon(name));
            place(`show-${side}`).setAttribute('aria-label', label);
            place(`show-${side}`).title = label;
            place(`show-${side}`).addEventListener('click', () => toggle(side));
        }
        // In a notebook's frame the picture is what matters at first.
        const framed = window.top !== window;
        set('data', !framed);
        set('look', !framed && !narrow());
    }

    private key(event: KeyboardEvent): void {
        if (event.ctrlKey || event.metaKey || event.altKey) return;
        const target = event.target as HTMLElement;
        if (target.closest('input, select, textarea, dialog, [role=slider]')) return;
        const keys: Record<string, () => void> = {
            'f': () => this.model.fit(), 'o': () => this.toggleProjection(), 'l': () => void this.copyLink(),
            's': () => void this.savePicture(), 't': () => this.toggleTheme(), '?': () => this.showHelp(),
            '[': () => this.time.step(-1), ']': () => this.time.step(1),
        };
        const act = keys[event.key.toLowerCase()];
        if (event.key === ' ' && target.closest('button') === null) {
            this.time.toggle();
            event.preventDefault();
        }
        act?.();
    }

    private toggleProjection(): void {
        if (this.model.camera) this.model.setCamera(toggleProjection(this.model.camera));
    }

    private toggleTheme(): void {
        const root = document.documentElement;
        const dark = root.dataset.theme ? root.dataset.theme === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
        root.dataset.theme = dark ? 'light' : 'dark';
    }

    private async copyLink(): Promise<void> {
        await this.keepInAddress();
        const link = new URL(`#${await this.model.toFragment()}`, location.href);
        const copied = await copyText(link.href);
        tell(copied ? 'The link to this view is copied.' : 'The address of this page is the link to this view.');
    }

    /// A link that is good once, for somebody who looks on.
    private async share(): Promise<void> {
        const answer = await fetch('link', {method: 'POST', body: 'follower'});
        if (!answer.ok) return tell(await answer.text(), true);
        const link = new URL('.', location.href);
        link.searchParams.set('token', (await answer.json()).token);
        tell(await copyText(link.href) ? 'A link for one follower is copied.' : link.href);
    }

    private async savePicture(): Promise<void> {
        const pixels = await this.server.grab();
        if (!pixels) return;
        const canvas = new OffscreenCanvas(pixels.width, pixels.height);
        canvas.getContext('2d')!.putImageData(pixels, 0, 0);
        download(`${this.fileName()}.png`, [await canvas.convertToBlob()], 'image/png');
    }

    /// The view as mote-frames and mote-view take it.
    private saveView(): void {
        const text = toJsonString(ViewSchema, this.model.whole(), {prettySpaces: 2});
        download(`${this.fileName()}.json`, [`{"views": [${text}]}\n`], 'application/json');
    }

    private async openView(file: File): Promise<void> {
        try {
            const content = JSON.parse(await file.text());
            await this.model.load(fromJson(ViewSchema, content.views?.[0] ?? content.view ?? content));
        } catch (error) {
            tell(`${file.name} holds no view: ${(error as Error).message}`, true);
        }
    }

    private fileName(): string {
        return (this.model.layer?.dataset ?? 'mote').replace(/[^\w.-]+/g, '-');
    }

    private showHelp(): void {
        const dialog = place('help') as HTMLDialogElement;
        const rows = [
            ['drag, arrows', 'orbit'], ['shift or right button, two fingers', 'pan'], ['wheel, pinch, + −', 'nearer, away'],
            ['F', 'fit'], ['O', 'perspective or parallel'], ['space', 'play'], ['[ ]', 'step back, on'],
            ['S', 'save the picture'], ['L', 'copy a link to this view'], ['T', 'light or dark'],
        ];
        dialog.replaceChildren(
            h('h2', {id: 'help-title'}, 'Keys and gestures'),
            h('dl', {}, ...rows.flatMap(([keys, what]) => [h('dt', {}, h('kbd', {}, keys)), h('dd', {}, what)])),
            h('button', {type: 'button', class: 'button first', onclick: () => dialog.close()}, 'Close'));
        dialog.showModal();
    }
}

new Page();
