// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/hidden_area.h"

#include <cmath>
#include <numbers>

namespace mote::render {

double discArea(double size) {
    return size > 1.0 ? std::numbers::pi * (0.25 * size * size + 1.0 / 12.0) : size * size;
}

double hiddenBy(double tau, double size) {
    if (size <= 1.0) return -std::expm1(-tau);
    if (tau < 1e-3) return tau * discArea(size);  // what follows would lose its digits
    const double inner = 0.5 * size - 0.5, reach = 0.5 * size + 0.5, left = std::exp(-tau);
    const double edge = reach * (1.0 - (1.0 - left) / tau) - (0.5 - (1.0 - left * (1.0 + tau)) / (tau * tau));
    return std::numbers::pi * (inner * inner * (1.0 - left) + 2.0 * edge);
}

double tauHiding(double area, double size, double most) {
    return rootBetween(0.0, most, area, [&](double tau) { return hiddenBy(tau, size); });
}

}  // namespace mote::render
