// SPDX-License-Identifier: GPL-3.0-or-later
//
// A curve of knots over a histogram: knots are dragged, added by a click on the empty plot, and removed by a double
// click or the Delete key; arrows move the one that has the focus.
import {h, trimmed} from './dom';

export interface Knot {
    x: number;
    y: number;
}

export interface CurveSettings {
    label: string;
    from: number;
    to: number;
    unit: string;
    histogram: number[];
    read(): Knot[];
    write(knots: Knot[], moving: boolean): void;
}

const space = 'http://www.w3.org/2000/svg';
const [width, height, margin] = [260, 96, 6];

function svg(tag: string, attributes: Record<string, string | number>): SVGElement {
    const element = document.createElementNS(space, tag);
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
    return element;
}

export function curveEditor(settings: CurveSettings): HTMLElement {
    const span = settings.to - settings.from || 1;
    const toX = (x: number) => margin + (width - 2 * margin) * (x - settings.from) / span;
    const toY = (y: number) => height - margin - (height - 2 * margin) * y;
    const plot = svg('svg', {viewBox: `0 0 ${width} ${height}`, class: 'curve', role: 'group', 'aria-label': settings.label});
    let dragged = -1;

    const clampX = (x: number) => Math.min(Math.max(x, settings.from), settings.to);
    const at = (event: PointerEvent | MouseEvent): Knot => {
        const box = plot.getBoundingClientRect();
        const x = (event.clientX - box.left) / box.width * width;
        const y = (event.clientY - box.top) / box.height * height;
        return {
            x: clampX(settings.from + span * (x - margin) / (width - 2 * margin)),
            y: Math.min(Math.max((height - margin - y) / (height - 2 * margin), 0), 1),
        };
    };

    /// A knot stays between its neighbours: the numbers of a curve ascend.
    const move = (index: number, to: Knot, moving: boolean) => {
        const knots = settings.read();
        const gap = span * 1e-4;
        const least = index > 0 ? knots[index - 1].x + gap : settings.from;
        const most = index + 1 < knots.length ? knots[index + 1].x - gap : settings.to;
        knots[index] = {x: Number(Math.min(Math.max(to.x, least), most).toPrecision(6)), y: Number(to.y.toFixed(4))};
        settings.write(knots, moving);
        draw();
    };

    const remove = (index: number) => {
        settings.write(settings.read().filter((_, i) => i !== index), false);
        draw();
    };

    const histogram = () => {
        const counts = settings.histogram.map((count) => Math.log1p(count));
        const most = Math.max(...counts, 1e-9);
        const step = (width - 2 * margin) / Math.max(counts.length, 1);
        const points = counts.flatMap((count, i) => {
            const y = toY(0.92 * count / most).toFixed(1);
            return [`${(margin + i * step).toFixed(1)},${y}`, `${(margin + (i + 1) * step).toFixed(1)},${y}`];
        });
        return svg('polygon', {class: 'curve-histogram',
                               points: [`${margin},${toY(0)}`, ...points, `${width - margin},${toY(0)}`].join(' ')});
    };

    const dot = (knot: Knot, index: number) => {
        const mark = svg('circle', {class: 'curve-knot', cx: toX(knot.x), cy: toY(knot.y), r: 5, tabindex: 0,
                                    role: 'slider', 'aria-label': `knot ${index + 1} of ${settings.label}`,
                                    'aria-valuemin': 0, 'aria-valuemax': 1, 'aria-valuenow': knot.y,
                                    'aria-valuetext': `${trimmed(knot.y)} at ${trimmed(knot.x)} ${settings.unit}`});
        mark.addEventListener('pointerdown', (event) => {
            event.stopPropagation();
            dragged = index;
            plot.setPointerCapture((event as PointerEvent).pointerId);
        });
        mark.addEventListener('dblclick', () => remove(index));
        mark.addEventListener('keydown', (event) => keyed(event as KeyboardEvent, index, knot));
        return mark;
    };

    const keyed = (event: KeyboardEvent, index: number, knot: Knot) => {
        const steps: Record<string, [number, number]> = {
            ArrowLeft: [-0.01, 0], ArrowRight: [0.01, 0], ArrowUp: [0, 0.02], ArrowDown: [0, -0.02]};
        const step = steps[event.key];
        if (event.key === 'Delete' || event.key === 'Backspace') remove(index);
        else if (step) move(index, {x: knot.x + step[0] * span, y: Math.min(Math.max(knot.y + step[1], 0), 1)}, false);
        else return;
        event.preventDefault();
        (plot.querySelectorAll('.curve-knot')[index] as SVGElement | undefined)?.focus();
    };

    const draw = () => {
        const knots = settings.read();
        plot.replaceChildren(histogram());
        if (knots.length > 0) {
            const line = [`${margin},${toY(knots[0].y)}`, ...knots.map((knot) => `${toX(knot.x)},${toY(knot.y)}`),
                          `${width - margin},${toY(knots[knots.length - 1].y)}`];
            plot.append(svg('polyline', {class: 'curve-line', points: line.join(' ')}), ...knots.map(dot));
        } else {
            const words = svg('text', {class: 'curve-hint', x: width / 2, y: height / 2});
            words.textContent = 'chosen by the data – click to draw your own';
            plot.append(words);
        }
    };

    plot.addEventListener('pointerdown', (event) => {
        const placed = at(event as PointerEvent);
        const knots = [...settings.read(), placed].sort((a, b) => a.x - b.x);
        dragged = knots.indexOf(placed);
        if (knots.length === 1) knots.unshift({x: settings.from, y: 0});
        if (knots.length === 2 && dragged === 0) dragged = 1;
        plot.setPointerCapture((event as PointerEvent).pointerId);
        settings.write(knots, true);
        draw();
    });
    plot.addEventListener('pointermove', (event) => {
        if (dragged >= 0) move(dragged, at(event as PointerEvent), true);
    });
    plot.addEventListener('pointerup', () => {
        if (dragged >= 0) settings.write(settings.read(), false);
        dragged = -1;
    });
    const whole = h('div', {class: 'curve-box'}, plot);
    whole.addEventListener('mote-refresh', draw);
    draw();
    return whole;
}
