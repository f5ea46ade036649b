// SPDX-License-Identifier: GPL-3.0-or-later
//
// Controls made from the schema: what a field may be, is by default, is called and means stands on the field itself
// (protocol/options.proto), so that a new field of a style needs no line here.
import {ScalarType, create, getOption, type DescField, type DescMessage, type Message} from '@bufbuild/protobuf';
import {amount, h, icon, trimmed} from './dom';
import {curveEditor} from './curve';
import {colorMaps} from './generated/color_maps';
import {Facts_As, is, type Facts} from './generated/protocol/options_pb';

type Plain = Record<string, unknown>;

/// Where the message of a panel is: absent messages are made by the first edit.
export interface Place {
    get(): Message | undefined;
    make(): Message;
}

export interface PanelSettings {
    /// A field's control was moved; `moving`: the hand is still on it.
    changed(moving: boolean, field: DescField): void;
    /// Names that a field of words takes besides what the schema says: columns.
    words?(field: DescField): string[] | undefined;
    /// Where a curve's first number begins and ends, and how many there are of each value.
    domain?(field: DescField): {from: number, to: number, histogram: number[], unit: string} | undefined;
    /// Fields that have no place here.
    skip?: string[];
}

/// What a row or a curve hears of where its field was changed by another's.
export const refreshEvent = 'mote-refresh';

let lastId = 0;

export const factsOf = (field: DescField): Facts | undefined => {
    const facts = getOption(field, is);
    return facts;
};

/// Names of fields that are no words.
const words: Record<string, string> = {
    fov_y_degrees: 'angle of view', size_pixels: 'point size', color_map: 'colour map', color: 'colour', of_pixel: 'of a pixel',
    color_bar: 'colour bar', font_points: 'font size',
};
const titled = (name: string) => name.replace(/_/g, ' ').replace(/^./, (first) => first.toUpperCase());
export const labelOf = (field: DescField): string => titled(factsOf(field)?.label || words[field.name] || field.name);

const valuesOf = (place: Place): Plain => (place.get() ?? {}) as Plain;

/// Controls of all fields of a message that people can set one by one.
export function messagePanel(desc: DescMessage, place: Place, settings: PanelSettings): HTMLElement {
    const rows = desc.fields.filter((field) => !settings.skip?.includes(field.name))
        .map((field) => fieldRow(field, place, settings)).filter((row) => row !== undefined);
    return h('div', {class: 'panel-rows'}, ...rows);
}

function fieldRow(field: DescField, place: Place, settings: PanelSettings): HTMLElement | undefined {
    const facts = factsOf(field);
    if (field.fieldKind === 'message') return facts?.filled || facts?.label ? group(field, place, settings) : undefined;
    if (field.fieldKind === 'list') return listRow(field, facts, place, settings);
    if (field.fieldKind !== 'scalar') return undefined;
    if (field.scalar === ScalarType.BOOL) return switchRow(field, facts, place, settings);
    if (field.scalar === ScalarType.STRING) return wordRow(field, facts, place, settings);
    if (field.scalar === ScalarType.DOUBLE) return numberRow(field, facts, place, settings);
    return undefined;
}

function listRow(field: DescField & {fieldKind: 'list'}, facts: Facts | undefined, place: Place,
                 settings: PanelSettings): HTMLElement | undefined {
    if (facts?.as === Facts_As.COLOR) return colorRow(field, facts, place, settings);
    if (facts?.as === Facts_As.DIRECTION) return numbersRow(field, facts, place, settings, 3);
    if (facts?.as === Facts_As.KNOTS && field.listKind === 'message') return curveRow(field, place, settings);
    if (field.listKind === 'scalar' && facts?.count === 2) return numbersRow(field, facts, place, settings, 2);
    return undefined;
}

/// A label, its control, and a button that gives the field back to its default.
function row(field: DescField, control: HTMLElement, id: string, place: Place, settings: PanelSettings,
             refresh: () => void): HTMLElement {
    const facts = factsOf(field);
    const reset = h('button', {type: 'button', class: 'reset', title: 'Back to the default',
                               'aria-label': `${labelOf(field)}: back to the default`}, icon('reset'));
    const whole = h('div', {class: 'row', title: facts?.help ?? ''},
                    h('label', {for: id, id: `${id}-label`}, labelOf(field)), control, reset);
    const update = () => {
        const value = valuesOf(place)[field.localName];
        const set = Array.isArray(value) ? value.length > 0 : value !== undefined && value !== false && value !== '';
        whole.classList.toggle('set', set);
        reset.disabled = !set;
    };
    reset.addEventListener('click', () => {
        const message = place.get() as unknown as Plain | undefined;
        if (!message) return;
        message[field.localName] = Array.isArray(message[field.localName]) ? [] : emptyOf(field);
        refresh();
        update();
        settings.changed(false, field);
    });
    whole.addEventListener(refreshEvent, () => {
        refresh();
        update();
    });
    control.addEventListener('input', update);
    control.addEventListener('change', update);
    update();
    return whole;
}

function emptyOf(field: DescField): unknown {
    if (field.presence !== 2) return undefined;  // explicit: it can be absent
    if (field.fieldKind === 'scalar' && field.scalar === ScalarType.STRING) return '';
    return field.fieldKind === 'scalar' && field.scalar === ScalarType.BOOL ? false : undefined;
}

const put = (field: DescField, place: Place, value: unknown) => {
    (place.make() as unknown as Plain)[field.localName] = value;
};

function switchRow(field: DescField, facts: Facts | undefined, place: Place, settings: PanelSettings): HTMLElement {
    const id = `field-${++lastId}`;
    const box = h('input', {type: 'checkbox', id, class: 'switch', role: 'switch'});
    const refresh = () => {
        box.checked = (valuesOf(place)[field.localName] ?? facts?.default[0] === 1) as boolean;
    };
    refresh();
    box.addEventListener('change', () => {
        put(field, place, box.checked);
        settings.changed(false, field);
    });
    return row(field, box, id, place, settings, refresh);
}

function wordRow(field: DescField, facts: Facts | undefined, place: Place, settings: PanelSettings):
    HTMLElement | undefined {
    const maps = facts?.as === Facts_As.COLOR_MAP;
    const words = settings.words?.(field) ?? (maps ? Object.keys(colorMaps) : facts?.oneOf);
    if (!words || words.length === 0) return undefined;
    const id = `field-${++lastId}`;
    const first = facts?.emptyWord || (facts?.defaultWord ? `default: ${facts.defaultWord}` : 'default');
    const select = h('select', {id}, h('option', {value: ''}, first),
                     ...words.map((word) => h('option', {value: word}, word)));
    const preview = h('div', {class: 'color-map', 'aria-hidden': 'true'});
    const refresh = () => {
        select.value = String(valuesOf(place)[field.localName] ?? '');
        const colors = colorMaps[select.value || facts?.defaultWord || ''];
        preview.style.background = colors ? `linear-gradient(90deg, ${colors.join(', ')})` : '';
        preview.hidden = !colors;
    };
    refresh();
    select.addEventListener('change', () => {
        put(field, place, select.value);
        refresh();
        settings.changed(false, field);
    });
    const control = maps ? h('div', {class: 'with-preview'}, select, preview) : select;
    return row(field, control, id, place, settings, refresh);
}

/// How a slider's place, 0 to 1, becomes a value and back.
function scaleOf(facts: Facts | undefined): {to(place: number): number, from(value: number): number} | undefined {
    const from = facts?.slider?.from ?? facts?.from;
    const to = facts?.slider?.to ?? facts?.to;
    if (from === undefined || to === undefined || to - from > 1e5) return undefined;
    if (facts?.slider?.log || (facts?.as === Facts_As.LENGTH && from > 0))
        return {to: (place) => from * Math.pow(to / from, place), from: (value) => Math.log(value / from) / Math.log(to / from)};
    return {to: (place) => from + (to - from) * place, from: (value) => (value - from) / (to - from)};
}

function numberRow(field: DescField, facts: Facts | undefined, place: Place, settings: PanelSettings): HTMLElement {
    const id = `field-${++lastId}`;
    const scale = scaleOf(facts);
    const number = h('input', {type: 'number', step: 'any', inputMode: 'decimal', id: scale ? `${id}-number` : id,
                               'aria-labelledby': `${id}-label`, min: facts?.from, max: facts?.to});
    const slider = scale && h('input', {type: 'range', min: '0', max: '1', step: '0.001', id});
    const fallback = facts?.default[0];
    const refresh = () => {
        const value = valuesOf(place)[field.localName] as number | undefined;
        number.value = value === undefined ? '' : trimmed(value);
        number.placeholder = fallback === undefined ? 'auto' : trimmed(fallback);
        if (slider) {
            slider.value = String(scale!.from(value ?? fallback ?? scale!.to(0.5)));
            slider.setAttribute('aria-valuetext', value === undefined ? `default ${number.placeholder}` : number.value);
        }
    };
    refresh();
    slider?.addEventListener('input', () => {
        put(field, place, Number(scale!.to(Number(slider.value)).toPrecision(4)));
        refresh();
        settings.changed(true, field);
    });
    slider?.addEventListener('change', () => settings.changed(false, field));
    number.addEventListener('change', () => {
        const value = number.value === '' ? undefined : Number(number.value);
        if (value !== undefined && !Number.isFinite(value)) return refresh();
        put(field, place, value === undefined ? undefined : clamp(value, facts));
        refresh();
        settings.changed(false, field);
    });
    return row(field, h('div', {class: 'number'}, slider, number), id, place, settings, refresh);
}

const clamp = (value: number, facts: Facts | undefined) =>
    Math.min(Math.max(value, facts?.from ?? -Infinity), facts?.to ?? Infinity);

function numbersRow(field: DescField, facts: Facts, place: Place, settings: PanelSettings, count: number): HTMLElement {
    const id = `field-${++lastId}`;
    const names = count === 3 ? ['x', 'y', 'z'] : ['from', 'to'];
    const inputs = names.map((name, i) => h('input', {
        type: 'number', step: 'any', id: i === 0 ? id : `${id}-${name}`, 'aria-label': `${labelOf(field)}, ${name}`}));
    const refresh = () => {
        const values = (valuesOf(place)[field.localName] ?? []) as number[];
        inputs.forEach((input, i) => {
            input.value = values.length === count ? trimmed(values[i]) : '';
            input.placeholder = facts.default.length === count ? trimmed(facts.default[i]) : 'auto';
        });
    };
    refresh();
    for (const input of inputs) input.addEventListener('change', () => {
        const values = inputs.map((each, i) => each.value === '' ? facts.default[i] : Number(each.value));
        const whole = values.every((value) => value !== undefined && Number.isFinite(value));
        if (!whole || (count === 2 && values[0] >= values[1])) return;
        put(field, place, values.map((value) => clamp(value, facts)));
        refresh();
        settings.changed(false, field);
    });
    return row(field, h('div', {class: 'numbers'}, ...inputs), id, place, settings, refresh);
}

export const toHex = (color: number[]): string =>
    '#' + color.map((part) => Math.round(255 * part).toString(16).padStart(2, '0')).join('');
export const fromHex = (text: string): number[] =>
    [1, 3, 5].map((at) => Number((parseInt(text.slice(at, at + 2), 16) / 255).toFixed(4)));

function colorRow(field: DescField, facts: Facts, place: Place, settings: PanelSettings): HTMLElement {
    const id = `field-${++lastId}`;
    const input = h('input', {type: 'color', id});
    const refresh = () => {
        const value = (valuesOf(place)[field.localName] ?? []) as number[];
        input.value = toHex(value.length === 3 ? value : facts.default.length === 3 ? facts.default : [0.5, 0.5, 0.5]);
    };
    refresh();
    input.addEventListener('input', () => {
        put(field, place, fromHex(input.value));
        settings.changed(true, field);
    });
    return row(field, input, id, place, settings, refresh);
}

/// Fields of a message within the message; one that is not there is made by the first edit.
function group(field: DescField & {fieldKind: 'message'}, place: Place, settings: PanelSettings): HTMLElement {
    const inner: Place = {
        get: () => valuesOf(place)[field.localName] as Message | undefined,
        make: () => {
            const message = place.make() as unknown as Record<string, Message | undefined>;
            return message[field.localName] ??= create(field.message);
        },
    };
    return h('details', {class: 'group', open: field.name !== 'light'},
             h('summary', {title: factsOf(field)?.help ?? ''}, labelOf(field)), messagePanel(field.message, inner, settings));
}

function curveRow(field: DescField & {fieldKind: 'list', listKind: 'message'}, place: Place, settings: PanelSettings):
    HTMLElement | undefined {
    const domain = settings.domain?.(field);
    if (!domain) return undefined;
    const [x, y] = field.message.fields;
    const editor = curveEditor({
        label: `${labelOf(field)}: ${y.name} over ${x.name}`, ...domain,
        read: () => ((valuesOf(place)[field.localName] ?? []) as unknown as Plain[])
            .map((knot) => ({x: knot[x.localName] as number, y: knot[y.localName] as number})),
        write: (knots, moving) => {
            const before = (valuesOf(place)[field.localName] ?? []) as unknown as Plain[];
            put(field, place, knots.map((knot, i) =>
                create(field.message, {...(before.length === knots.length ? before[i] : {}), [x.localName]: knot.x,
                                       [y.localName]: knot.y})));
            settings.changed(moving, field);
        },
    });
    return h('div', {class: 'curve-row'}, h('div', {class: 'curve-title'}, titled(y.name), h('span', {},
             `${trimmed(domain.from)} – ${amount(domain.to)} ${domain.unit}`)), editor);
}
