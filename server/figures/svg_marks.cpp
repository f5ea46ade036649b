// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/svg_marks.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <numbers>

#include "protocol/base/utf8.h"
#include "server/figures/cairo_surface.h"

namespace mote::server {
namespace {

constexpr double emUnits = 1000.0;  // in which a glyph is told
constexpr double haloWidth = 0.3;   // em

class SvgMarks {
  public:
    explicit SvgMarks(const Typeface& typeface) : typeface_(typeface) {}

    Status operator()(const LineMark& line) {
        add("<path d=\"{}{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"",
            wayOf(line.points), line.closed ? "z" : "", colorOf(line.ink), shortNumber(line.width));
        if (line.dashed) add(" stroke-dasharray=\"{}\"", shortNumber(3.0 * line.width));
        end("stroke", line.ink);
        return success();
    }
    Status operator()(const AreaMark& area) {
        add("<path d=\"{}z\" fill=\"{}\"", wayOf(area.points), colorOf(area.ink));
        end("fill", area.ink);
        return success();
    }
    Status operator()(const ImageMark& image) {
        MOTE_ASSIGN_OR_RETURN(const auto png, pngOf(surfaceOf(image).get()));
        add("<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" "
            "style=\"image-rendering:pixelated\" xlink:href=\"data:image/png;base64,{}\"/>\n",
            shortNumber(image.box.low.x), shortNumber(image.box.low.y), shortNumber(image.box.size().x),
            shortNumber(image.box.size().y), base64(png));
        return success();
    }
    Status operator()(const TextMark& text) {
        const auto line = typeface_.layOut(text.text, text.size);
        add("<g role=\"img\" aria-label=\"{}\" transform=\"translate({} {})", escapedXml(toPlain(text.text)),
            shortNumber(text.place.x), shortNumber(text.place.y));
        if (text.angle != 0.0) add(" rotate({})", shortNumber(text.angle * 180.0 / std::numbers::pi));
        add(" translate({} {})\">\n", shortNumber(-text.anchor.x * line.width),
            shortNumber((1.0 - text.anchor.y) * Typeface::capHeight * text.size));
        if (text.halo.opacity > 0.0) {
            add("<g stroke=\"{}\" fill=\"none\" stroke-linejoin=\"round\" stroke-width=\"{}\"",
                colorOf(text.halo), shortNumber(haloWidth * emUnits));
            if (text.halo.opacity < 1.0) add(" opacity=\"{}\"", shortNumber(text.halo.opacity));
            add(">\n");
            addGlyphs(line);
            add("</g>\n");
        }
        add("<g fill=\"{}\"", colorOf(text.ink));
        if (text.ink.opacity < 1.0) add(" opacity=\"{}\"", shortNumber(text.ink.opacity));
        add(">\n");
        addGlyphs(line);
        add("</g>\n</g>\n");
        return success();
    }

    std::string take() { return std::move(text_); }

  private:
    template <class... Values>
    void add(fmt::format_string<Values...> format, Values&&... values) {
        fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
    }
    static std::string colorOf(const Ink& ink) { return hexColor(glm::vec3(ink.color)); }
    void end(const char* what, const Ink& ink) {
        if (ink.opacity < 1.0) add(" {}-opacity=\"{}\"", what, shortNumber(ink.opacity));
        add("/>\n");
    }
    static std::string wayOf(const std::vector<glm::dvec2>& points) {
        std::string way;
        for (const auto& point : points) {
            way += way.empty() ? "M" : "L";
            way += shortNumber(point.x) + " " + shortNumber(point.y);
        }
        return way;
    }
    void addGlyphs(const TextLine& line) {
        for (const auto& glyph : line.glyphs) {
            const auto& outline = typeface_.outline(glyph);
            if (outline.contours.empty()) continue;
            add("<path transform=\"translate({} {}) scale({:.6g})\" d=\"", shortNumber(glyph.place.x),
                shortNumber(glyph.place.y), glyph.size / emUnits);
            const auto place = [&](const glm::dvec2& at) {
                return fmt::format("{} {}", std::lround(emUnits * at.x), std::lround(emUnits * at.y));
            };
            for (const auto& contour : outline.contours) {
                add("M{}", place(contour.begin));
                for (std::size_t i = 0; i + 2 < contour.curves.size(); i += 3) {
                    add("C{} {} {}", place(contour.curves[i]), place(contour.curves[i + 1]),
                        place(contour.curves[i + 2]));
                }
                add("z");
            }
            add("\"/>\n");
        }
    }

    const Typeface& typeface_;
    std::string text_;
};

}  // namespace

Result<std::string> svgOf(const Marks& marks, const Typeface& typeface) {
    SvgMarks writer(typeface);
    for (const auto& mark : marks) MOTE_RETURN_IF_ERROR(std::visit(writer, mark));
    return writer.take();
}

std::string escapedXml(std::string_view text) {
    std::string escaped;
    const std::string valid = toUtf8(text);
    for (std::string_view left = valid; !left.empty();) {
        const auto character = left.substr(0, characterLength(left));
        left.remove_prefix(character.size());
        if (character == "&")
            escaped += "&amp;";
        else if (character == "<")
            escaped += "&lt;";
        else if (character == ">")
            escaped += "&gt;";
        else if (character == "\"")
            escaped += "&quot;";
        else if (isControl(character) || character == "\uFFFE" || character == "\uFFFF")
            escaped += "?";
        else
            escaped += character;
    }
    return escaped;
}

std::string base64(const std::vector<std::uint8_t>& bytes) {
    constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve(bytes.size() / 3 * 4 + 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t left = bytes.size() - i;
        const std::uint32_t group = (std::uint32_t{bytes[i]} << 16) |
                                    (left > 1 ? std::uint32_t{bytes[i + 1]} << 8 : 0U) |
                                    (left > 2 ? std::uint32_t{bytes[i + 2]} : 0U);
        for (std::size_t digit = 0; digit < 4; ++digit) {
            text += digit <= left ? digits[(group >> (18 - 6 * digit)) & 63] : '=';
        }
    }
    return text;
}

std::string shortNumber(double value, int decimals) {
    auto text = fmt::format("{:.{}f}", value, decimals);
    if (text.find('.') != std::string::npos) {
        text.erase(text.find_last_not_of('0') + 1);
        if (text.back() == '.') text.pop_back();
    }
    return text == "-0" ? "0" : text;
}

std::string hexColor(const glm::vec3& color) {
    const auto byte = [](float value) { return std::lround(value * 255.0F); };
    return fmt::format("#{:02x}{:02x}{:02x}", byte(color.x), byte(color.y), byte(color.z));
}

}  // namespace mote::server
