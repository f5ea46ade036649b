// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/reference/generated_image.h"

#include <array>
#include <utility>

#include "tests/support/random.h"

namespace mote::test {

std::span<const std::string_view> imageForms() {
    static constexpr std::array<std::string_view, 4> forms{"even", "smooth", "noise", "bright"};
    return forms;
}

std::shared_ptr<const storage::ColorImage> imageOf(const std::string& form, std::uint32_t number) {
    static constexpr std::array<std::pair<std::uint32_t, std::uint32_t>, 6> sizes{
        {{1, 1}, {7, 3}, {3, 40}, {64, 48}, {200, 2}, {130, 90}}};
    const auto [width, height] = sizes[number % sizes.size()];
    storage::ColorImage image{width, height, 1.0 * width, 1.0 * height, {}};
    // As if averaged down: of the last pixels a part is there.
    if (number >= sizes.size()) image.columns -= 0.25;
    if (number >= sizes.size()) image.rows -= 0.5;
    Random random(number, 11);
    const auto color = [&] {
        const auto red = static_cast<float>(random.unit()), green = static_cast<float>(random.unit());
        return glm::vec3(red, green, static_cast<float>(random.unit()));
    };
    const glm::vec3 first = color(), last = color();
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            const float across = (static_cast<float>(x) + 0.5F) / static_cast<float>(width);
            const float down = (static_cast<float>(y) + 0.5F) / static_cast<float>(height);
            glm::vec3 value = first;
            if (form == "smooth") value = first + across * down * (last - first);
            if (form == "noise") value = color();
            if (form == "bright") value = (x + y) % 5 == 0 ? 8.0F * last : 0.2F * first;
            image.values.push_back(value);
        }
    }
    return std::make_shared<const storage::ColorImage>(std::move(image));
}

}  // namespace mote::test
