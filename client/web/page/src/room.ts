// SPDX-License-Identifier: GPL-3.0-or-later
//
// A room: a view that this page shares with a notebook, by a name that nobody guesses. What is put there by the notebook
// is shown here, and what a hand changes here is put there once it rests.
import {fromBinary, toBinary} from '@bufbuild/protobuf';
import {ViewSchema, type View} from './generated/protocol/mote_pb';

const pauseMs = 2000;

export class Room {
    private readonly url: URL;
    private number = 0;
    private last = '';
    private size = {width: 0, height: 0};

    /// The name that an address's fragment gives.
    static nameOf(fragment: string): string | undefined {
        return /^#?room=([0-9a-f]{16,64})$/.exec(fragment)?.[1];
    }

    constructor(name: string, private readonly show: (view: View) => Promise<void>) {
        this.url = new URL(`room/${name}`, document.baseURI);
        // A notebook gives the frame its height now: where no page comes, its cell has no hole.
        if (parent !== window) parent.postMessage('mote-room', '*');
        void this.listen();
    }

    /// Tells the notebook what is seen. What no hand changed here (a camera that the server fitted) gives way to whatever
    /// was put there since. Each window has a size of its own: that of the view stays as it was put.
    async put(view: View, byHand: boolean): Promise<void> {
        Object.assign(view, this.size);
        const bytes = toBinary(ViewSchema, view);
        const text = bytes.join();
        if (text === this.last) return;
        this.last = text;
        const answer = await fetch(byHand ? this.url : `${this.url}?after=${this.number}`, {method: 'POST', body: bytes as BodyInit});
        if (answer.ok) this.number = Number(answer.headers.get('X-Number'));
    }

    private async listen(): Promise<void> {
        while (true) {
            try {
                const answer = await fetch(`${this.url}?after=${this.number}`);
                if (answer.status === 403) return;
                const number = Number(answer.headers.get('X-Number'));
                if (answer.status === 200 && number !== this.number) await this.take(number, await answer.arrayBuffer());
                if (!answer.ok) throw new Error(answer.statusText);
            } catch {
                await new Promise((done) => setTimeout(done, pauseMs));
            }
        }
    }

    private async take(number: number, bytes: ArrayBuffer): Promise<void> {
        this.number = number;
        const text = new Uint8Array(bytes).join();
        if (text === this.last) return;
        this.last = text;
        const view = fromBinary(ViewSchema, new Uint8Array(bytes));
        this.size = {width: view.width, height: view.height};
        await this.show(view);
    }
}
