// SPDX-License-Identifier: GPL-3.0-or-later
//
// Tabs: one of several panels is seen. Arrow keys go from one to the next.
import {h} from './dom';

export interface Tab {
    name: string;
    panel: HTMLElement;
    shown(): void;
}

export function tabs(place: HTMLElement, all: Tab[]): void {
    const buttons = all.map((tab, i) => {
        tab.panel.id = `panel-${i}`;
        tab.panel.setAttribute('role', 'tabpanel');
        tab.panel.setAttribute('aria-labelledby', `tab-${i}`);
        return h('button', {type: 'button', role: 'tab', id: `tab-${i}`, 'aria-controls': `panel-${i}`,
                            onclick: () => choose(i)}, tab.name);
    });
    const choose = (index: number) => {
        all.forEach((tab, i) => {
            tab.panel.hidden = i !== index;
            buttons[i].setAttribute('aria-selected', String(i === index));
            buttons[i].tabIndex = i === index ? 0 : -1;
        });
        all[index].shown();
    };
    const bar = h('div', {class: 'tabs', role: 'tablist', 'aria-label': 'Panels'}, ...buttons);
    bar.addEventListener('keydown', (event) => {
        const step = event.key === 'ArrowRight' ? 1 : event.key === 'ArrowLeft' ? -1 : 0;
        const now = buttons.indexOf(document.activeElement as HTMLButtonElement);
        if (step === 0 || now < 0) return;
        const next = (now + step + all.length) % all.length;
        choose(next);
        buttons[next].focus();
        event.preventDefault();
    });
    place.append(bar, ...all.map((tab) => tab.panel));
    choose(0);
}
