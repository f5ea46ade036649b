// SPDX-License-Identifier: GPL-3.0-or-later
//
// The viewer's gestures by mouse, touch and keyboard on the picture: drag orbits, with shift, the right button or two
// fingers it pans, wheel and pinch go nearer; arrows, plus and minus do the same without a hand on a mouse.
import {dolly, orbit, pan} from './camera';
import type {Camera} from './generated/protocol/mote_pb';
import type {Model} from './model';

export interface Point {
    x: number;
    y: number;
}

const tapPixels = 5;
const keyTurn = 1 / 24;
const wheelLine = 16;
const wheelStep = 60;

export class Gestures {
    /// Where a tap or a click without a drag was, as a part of the picture's width and height.
    onTap: (x: number, y: number) => void = () => {};
    /// Where given, drags draw a line instead: points as parts of the picture.
    onLasso: ((points: Point[], done: boolean) => void) | undefined;
    private readonly pointers = new Map<number, Point>();
    private begun: Point = {x: 0, y: 0};
    private line: Point[] = [];
    private dragged = false;
    private panning = false;

    constructor(private readonly place: HTMLElement, private readonly model: Model) {
        place.addEventListener('pointerdown', (event) => this.down(event));
        place.addEventListener('pointermove', (event) => this.move(event));
        place.addEventListener('pointerup', (event) => this.up(event));
        place.addEventListener('pointercancel', (event) => this.up(event));
        place.addEventListener('wheel', (event) => this.wheel(event), {passive: false});
        place.addEventListener('contextmenu', (event) => event.preventDefault());
        place.addEventListener('keydown', (event) => this.key(event));
    }

    private partOf(event: PointerEvent | MouseEvent): Point {
        const box = this.place.getBoundingClientRect();
        return {x: (event.clientX - box.left) / box.width, y: (event.clientY - box.top) / box.height};
    }

    private down(event: PointerEvent): void {
        if (event.target !== this.place) return;
        this.place.setPointerCapture(event.pointerId);
        this.pointers.set(event.pointerId, {x: event.clientX, y: event.clientY});
        this.begun = {x: event.clientX, y: event.clientY};
        this.dragged = this.pointers.size > 1;
        this.panning = event.button === 2 || event.button === 1 || event.shiftKey;
        this.line = [this.partOf(event)];
    }

    private move(event: PointerEvent): void {
        const before = this.pointers.get(event.pointerId);
        if (!before) return;
        const now = {x: event.clientX, y: event.clientY};
        if (!this.dragged && Math.hypot(now.x - this.begun.x, now.y - this.begun.y) < tapPixels) return;
        this.dragged = true;
        if (this.onLasso && this.pointers.size === 1) {
            this.line.push(this.partOf(event));
            this.onLasso(this.line, false);
        } else if (this.pointers.size === 1) {
            this.turn(before, now);
        } else if (this.pointers.size === 2) {
            this.pinch(event.pointerId, before, now);
        }
        this.pointers.set(event.pointerId, now);
    }

    private up(event: PointerEvent): void {
        if (!this.pointers.delete(event.pointerId)) return;
        if (!this.dragged && event.type === 'pointerup') {
            const part = this.partOf(event);
            this.onTap(part.x, part.y);
        } else if (this.onLasso && this.pointers.size === 0) {
            this.onLasso(this.line, true);
        } else if (this.pointers.size === 0 && this.model.camera) {
            this.model.wanted(false);
        }
    }

    private turn(before: Point, now: Point): void {
        const height = this.place.clientHeight;
        const dx = (now.x - before.x) / height;
        const dy = (now.y - before.y) / height;
        this.change((camera) => this.panning ? pan(camera, dx, dy) : orbit(camera, dx, dy));
    }

    private pinch(id: number, before: Point, now: Point): void {
        const other = [...this.pointers].find(([each]) => each !== id)![1];
        const height = this.place.clientHeight;
        const was = Math.hypot(before.x - other.x, before.y - other.y);
        const is = Math.hypot(now.x - other.x, now.y - other.y);
        // Each finger is half of the hand.
        const dx = (now.x - before.x) / 2 / height;
        const dy = (now.y - before.y) / 2 / height;
        const steps = was > 0 && is > 0 ? Math.log(was / is) / Math.log(0.9) : 0;
        this.change((camera) => dolly(pan(camera, dx, dy), steps));
    }

    private wheel(event: WheelEvent): void {
        event.preventDefault();
        const pixels = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? event.deltaY : event.deltaY * wheelLine;
        this.change((camera) => dolly(camera, -pixels / wheelStep * (event.ctrlKey ? 4 : 1)));
    }

    private key(event: KeyboardEvent): void {
        if (event.ctrlKey || event.metaKey || event.altKey) return;
        const turns: Record<string, [number, number]> = {
            ArrowLeft: [-keyTurn, 0], ArrowRight: [keyTurn, 0], ArrowUp: [0, -keyTurn], ArrowDown: [0, keyTurn]};
        const turn = turns[event.key];
        if (turn) this.change((camera) => event.shiftKey ? pan(camera, ...turn) : orbit(camera, ...turn));
        else if (event.key === '+' || event.key === '=') this.change((camera) => dolly(camera, 1));
        else if (event.key === '-') this.change((camera) => dolly(camera, -1));
        else return;
        event.preventDefault();
    }

    private change(by: (camera: Camera) => Camera): void {
        if (this.model.camera && !this.model.following) this.model.setCamera(by(this.model.camera), true);
    }
}
