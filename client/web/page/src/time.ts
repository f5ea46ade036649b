// SPDX-License-Identifier: GPL-3.0-or-later
//
// The time bar of a run: a slider over its steps, and playing them. The next step is asked for when the picture of the
// one before it is there, so that a slow line plays slower and skips nothing.
import {h, icon, iconButton, trimmed} from './dom';
import type {Model} from './model';

const mostStepsPerSecond = 15;

/// A time with its unit.
export function timeText(seconds: number): string {
    const size = Math.abs(seconds);
    for (const [least, unit] of [[1, 's'], [1e-3, 'ms'], [1e-6, 'µs'], [1e-9, 'ns'], [1e-12, 'ps']] as const)
        if (size >= least) return `${trimmed(seconds / least)} ${unit}`;
    return seconds === 0 ? '0 s' : `${trimmed(seconds / 1e-15)} fs`;
}

export class TimeBar {
    private readonly slider = h('input', {type: 'range', min: '0', step: '1', 'aria-label': 'Step'});
    private readonly output = h('output', {});
    private readonly play = iconButton('play', 'Play', () => this.toggle());
    private playing = false;
    private asked = 0;

    constructor(private readonly place: HTMLElement, private readonly model: Model) {
        this.slider.addEventListener('input', () => model.setStep(Number(this.slider.value), true));
        this.slider.addEventListener('change', () => model.setStep(Number(this.slider.value)));
        place.append(this.play, iconButton('back', 'Step back', () => this.step(-1)),
                     iconButton('next', 'Step on', () => this.step(1)), this.slider, this.output);
    }

    draw(): void {
        const {steps} = this.model;
        const there = steps > 1 && !this.model.following;
        this.place.hidden = !there;
        this.place.parentElement!.classList.toggle('timed', there);
        if (!there) return this.stop();
        const step = this.model.layer?.step ?? 0;
        const time = this.model.timeOf(step);
        this.slider.max = String(steps - 1);
        this.slider.value = String(step);
        const words = time === undefined ? '' : ` · ${timeText(time)}`;
        this.output.textContent = `${step} / ${steps - 1}${words}`;
        this.slider.setAttribute('aria-valuetext', `step ${step} of ${steps - 1}${words}`);
    }

    step(by: number): void {
        if (this.model.steps > 1) this.model.setStep((this.model.layer?.step ?? 0) + by);
    }

    toggle(): void {
        if (this.playing) return this.stop();
        if (this.model.steps < 2) return;
        this.playing = true;
        this.show();
        this.advance();
    }

    /// The picture of the latest step is there.
    shown(): void {
        if (!this.playing) return;
        const pause = Math.max(0, this.asked + 1000 / mostStepsPerSecond - performance.now());
        setTimeout(() => this.playing && this.advance(), pause);
    }

    private advance(): void {
        this.asked = performance.now();
        this.model.setStep(((this.model.layer?.step ?? 0) + 1) % this.model.steps, true);
    }

    private stop(): void {
        if (!this.playing) return;
        this.playing = false;
        this.show();
        this.model.wanted();
    }

    private show(): void {
        this.play.replaceChildren(icon(this.playing ? 'stop' : 'play'));
        this.play.setAttribute('aria-label', this.playing ? 'Pause' : 'Play');
        this.play.title = this.playing ? 'Pause' : 'Play';
    }
}
