// SPDX-License-Identifier: GPL-3.0-or-later
//
// Elements, made in one call; icons; and numbers as people read them.

type Child = Node | string | null | undefined | false;
type Props = {[name: string]: unknown};

/// An element: properties that begin with "on" are listeners, "class" and "aria-..." attributes, others properties.
export function h<K extends keyof HTMLElementTagNameMap>(tag: K, props: Props = {}, ...children: Child[]):
    HTMLElementTagNameMap[K] {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(props)) {
        if (value === undefined || value === null) continue;
        if (name.startsWith('on')) element.addEventListener(name.slice(2), value as EventListener);
        else if (name === 'class' || name === 'role' || name === 'for' || name.includes('-'))
            element.setAttribute(name, String(value));
        else (element as unknown as Props)[name] = value;
    }
    element.append(...children.filter((child): child is Node | string => !!child));
    return element;
}

const paths: Record<string, string> = {
    fit: 'M4 9V5a1 1 0 0 1 1-1h4M15 4h4a1 1 0 0 1 1 1v4M20 15v4a1 1 0 0 1-1 1h-4M9 20H5a1 1 0 0 1-1-1v-4',
    cube: 'M12 3 4 7.5v9L12 21l8-4.5v-9zM4 7.5l8 4.5 8-4.5M12 12v9',
    link: 'M10 14a4 4 0 0 0 6 0l3-3a4 4 0 0 0-6-6l-1 1M14 10a4 4 0 0 0-6 0l-3 3a4 4 0 0 0 6 6l1-1',
    share: 'M12 15V4m0 0L8 8m4-4 4 4M5 12v7a1 1 0 0 0 1 1h12a1 1 0 0 0 1-1v-7',
    save: 'M12 4v11m0 0 4-4m-4 4-4-4M5 20h14',
    theme: 'M20 14A8 8 0 1 1 10 4a6.5 6.5 0 0 0 10 10z',
    help: 'M9.5 9a2.5 2.5 0 1 1 3.6 2.2c-.7.4-1.1.9-1.1 1.8v.5M12 17v.01M12 21a9 9 0 1 0 0-18 9 9 0 0 0 0 18z',
    play: 'M7 5v14l11-7z',
    stop: 'M8 5v14M16 5v14',
    back: 'M15 6l-6 6 6 6',
    next: 'M9 6l6 6-6 6',
    reset: 'M5 12a7 7 0 1 0 2-5M5 4v4h4',
    close: 'M6 6l12 12M18 6 6 18',
    list: 'M4 6h16M4 12h16M4 18h16',
    sliders: 'M5 20v-6M5 10V4M12 20v-9M12 7V4M19 20v-3M19 13V4M3 14h4M10 7h4M17 17h4',
    lasso: 'M12 4c5 0 8 2.2 8 5s-3 5-8 5-8-2.2-8-5 3-5 8-5zM7 13c-1.500 1-1.500 3 0 3s1.500 2 0 4',
    plus: 'M12 5v14M5 12h14',
    eye: 'M2.5 12S6 5.500 12 5.500 21.500 12 21.500 12 18 18.500 12 18.500 2.500 12 2.500 12zM12 15a3 3 0 1 0 0-6 3 3 0 0 0 0 6z',
};

export function icon(name: string): SVGSVGElement {
    const space = 'http://www.w3.org/2000/svg';
    const svg = document.createElementNS(space, 'svg');
    svg.setAttribute('viewBox', '0 0 24 24');
    svg.setAttribute('class', 'icon');
    svg.setAttribute('aria-hidden', 'true');
    const path = document.createElementNS(space, 'path');
    path.setAttribute('d', paths[name]);
    svg.append(path);
    return svg;
}

/// A button with an icon alone, named for those who do not see it.
export function iconButton(name: string, label: string, onclick: () => void, more: Props = {}): HTMLButtonElement {
    return h('button', {type: 'button', class: 'icon-button', title: label, 'aria-label': label, onclick, ...more},
             icon(name));
}

/// 1234567 as "1.23 M".
export function amount(value: number): string {
    for (const [least, unit] of [[1e12, ' T'], [1e9, ' G'], [1e6, ' M'], [1e3, ' k']] as const)
        if (Math.abs(value) >= least) return trimmed(value / least, 3) + unit;
    return trimmed(value, 3);
}

/// A number with so many digits, without needless zeros.
export function trimmed(value: number, digits = 4): string {
    if (!Number.isFinite(value)) return '–';
    if (value === 0) return '0';
    const size = Math.abs(value);
    if (size >= 1e5 || size < 1e-3) return value.toExponential(digits - 1).replace(/\.?0+e/, 'e').replace('e+', 'e');
    return String(Number(value.toPrecision(digits)));
}

const prefixes = [[1e9, 'G'], [1e6, 'M'], [1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, 'µ'], [1e-9, 'n'], [1e-12, 'p'], [1e-15, 'f']] as const;

/// A number with its unit, which has a prefix that suits it: 2.5e-7 m is "250 nm".
export function quantity(value: number, unit: string, digits = 5): string {
    if (!Number.isFinite(value) || value === 0 || !['m', 's', 'eV', 'eV/c', 'C', 'rad'].includes(unit))
        return `${trimmed(value, digits)} ${unit}`.trim();
    const [factor, prefix] = prefixes.find(([least]) => Math.abs(value) >= least) ?? prefixes[prefixes.length - 1];
    return `${trimmed(value / factor, digits)} ${prefix}${unit}`;
}

/// Gives a place these children. Those that are there stay there, and only what is new, gone or elsewhere moves: a press
/// on what stays goes on, and so does focus.
export function setChildren(place: Element, children: HTMLElement[]): void {
    const focused = document.activeElement;
    const wanted = new Set<Element>(children);
    for (const child of [...place.children]) if (!wanted.has(child)) child.remove();
    let at = place.firstElementChild;
    for (const child of children) {
        if (child === at) at = at.nextElementSibling;
        else place.insertBefore(child, at);
    }
    if (focused instanceof HTMLElement && focused !== document.activeElement && place.contains(focused))
        focused.focus({preventScroll: true});
}

/// Gives a select these values and what people read of them; where they are there already, it stays as it is.
export function setOptions(select: HTMLSelectElement, options: [string, string][]): void {
    const same = select.options.length === options.length &&
        options.every(([value, text], i) => select.options[i].value === value && select.options[i].text === text);
    if (same) return;
    const {value} = select;
    select.replaceChildren(...options.map(([each, text]) => h('option', {value: each}, text)));
    if (options.some(([each]) => each === value)) select.value = value;
}

let messageTimer = 0;

/// A sentence for a while, also for those who hear the page.
export function tell(text: string, wrong = false): void {
    const place = document.getElementById('message')!;
    place.textContent = text;
    place.classList.toggle('wrong', wrong);
    place.classList.add('shown');
    clearTimeout(messageTimer);
    messageTimer = window.setTimeout(() => place.classList.remove('shown'), wrong ? 8000 : 3000);
}

export async function copyText(text: string): Promise<boolean> {
    try {
        await navigator.clipboard.writeText(text);
        return true;
    } catch {
        // Frames and plain http have no clipboard of their own.
        const area = h('textarea', {value: text, class: 'hidden-visually'});
        document.body.append(area);
        area.select();
        const copied = document.execCommand('copy');
        area.remove();
        return copied;
    }
}

export function download(name: string, parts: BlobPart[], type: string): void {
    const url = URL.createObjectURL(new Blob(parts, {type}));
    h('a', {href: url, download: name}).click();
    setTimeout(() => URL.revokeObjectURL(url), 60_000);
}
