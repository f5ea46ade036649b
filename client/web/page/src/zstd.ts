// SPDX-License-Identifier: GPL-3.0-or-later
//
// Lossless pictures: zstd's own decoder in WebAssembly, then the way back from the row filter (docs/PROTOCOL.md,
// "Pixels"). One at a time.

interface Exports {
    memory: WebAssembly.Memory;
    malloc(size: number): number;
    free(address: number): void;
    ZSTD_decompress(to: number, toSize: number, from: number, fromSize: number): number;
}

/// Memory of the decoder's that grows as it is needed and is kept.
class Room {
    private address = 0;
    private size = 0;

    constructor(private readonly zstd: Exports) {}

    of(size: number): number {
        if (size > this.size) {
            if (this.address) this.zstd.free(this.address);
            this.address = this.zstd.malloc(size);
            this.size = this.address ? size : 0;
            if (!this.address) throw new Error(`there is no memory for a picture of ${size} bytes`);
        }
        return this.address;
    }
}

export class Lossless {
    private readonly packed: Room;
    private readonly rows: Room;
    private image = new ImageData(1, 1);

    private constructor(private readonly zstd: Exports) {
        this.packed = new Room(zstd);
        this.rows = new Room(zstd);
    }

    static async load(url: URL): Promise<Lossless> {
        const bytes = await (await fetch(url)).arrayBuffer();
        const imports = {env: {emscripten_notify_memory_growth: () => {}}};
        const {instance} = await WebAssembly.instantiate(bytes, imports);
        return new Lossless(instance.exports as unknown as Exports);
    }

    /// The picture, valid until the next call. Throws where the bytes are not a picture of this size.
    decode(payload: Uint8Array, width: number, height: number): ImageData {
        const size = 3 * width * height;
        const from = this.packed.of(payload.length);
        const to = this.rows.of(size);
        new Uint8Array(this.zstd.memory.buffer, from, payload.length).set(payload);
        if (this.zstd.ZSTD_decompress(to, size, from, payload.length) !== size) throw new Error('a picture is damaged');
        if (this.image.width !== width || this.image.height !== height) this.image = new ImageData(width, height);
        unfilter(new Uint8Array(this.zstd.memory.buffer, to, size), width, height, this.image.data);
        return this.image;
    }
}

/// Rows of differences to the left neighbour as pixels; alpha is 255.
export function unfilter(rows: Uint8Array, width: number, height: number, pixels: Uint8ClampedArray): void {
    const out = new Uint32Array(pixels.buffer, pixels.byteOffset, width * height);
    let at = 0;
    let pixel = 0;
    for (let y = 0; y < height; ++y) {
        let red = 0;
        let green = 0;
        let blue = 0;
        for (let x = 0; x < width; ++x, at += 3) {
            red = (red + rows[at]) & 255;
            green = (green + rows[at + 1]) & 255;
            blue = (blue + rows[at + 2]) & 255;
            out[pixel++] = 0xff000000 | (blue << 16) | (green << 8) | red;
        }
    }
}
