// SPDX-License-Identifier: GPL-3.0-or-later
// Reads a volume in every sampler's place: see egl_device.cpp.

layout(local_size_x = 1) in;
layout(binding = 0) uniform sampler3D volumes[16];
layout(std430, binding = 0) writeonly buffer Sums { float sum; };

void main() {
    float all = 0.0;
    for (int i = 0; i < 16; ++i) all += texelFetch(volumes[i], ivec3(0), 0).r;
    sum = all;
}
