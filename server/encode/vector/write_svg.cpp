// SPDX-License-Identifier: GPL-3.0-or-later
//
// SVG as text: Cairo's SVG names no layers, and makes four curves of a circle.
#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <span>
#include <string>

#include "server/encode/vector/vector_drawing.h"
#include "server/figures/svg_marks.h"

namespace mote::server {
namespace {

constexpr double dotStroke = 0.01;  // mm: a pen must be moved to leave a mark
constexpr double inkUnits = 100.0;  // of a pixel, in which strokes are told

/// A number to a micrometre, without zeros that say nothing.
std::string number(double value) {
    return shortNumber(value);
}

/// The attribute of what is not opaque: a "fill-", a "stroke-", or all of a group.
std::string faded(const char* what, double opacity) {
    return opacity < 1.0 ? fmt::format(" {}opacity=\"{}\"", what, number(opacity)) : std::string();
}

class SvgText {
  public:
    explicit SvgText(const PageDrawing& drawing) : drawing_(drawing) {}

    Result<std::vector<std::uint8_t>> write() {
        open();
        MOTE_RETURN_IF_ERROR(addBeneath());
        addInks();
        for (std::size_t i = 0; i < drawing_.layers.size(); ++i) addLayer(i);
        MOTE_RETURN_IF_ERROR(addAnnotations());
        add("</svg>\n");
        return std::vector<std::uint8_t>(text_.begin(), text_.end());
    }

  private:
    template <class... Values>
    void add(fmt::format_string<Values...> format, Values&&... values) {
        fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
    }

    void open() {
        const auto width = number(drawing_.layout.width);
        const auto height = number(drawing_.layout.height);
        add("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
            "<svg xmlns=\"http://www.w3.org/2000/svg\" "
            "xmlns:xlink=\"http://www.w3.org/1999/xlink\" "
            "xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\" "
            "version=\"1.1\" width=\"{0}mm\" height=\"{1}mm\" viewBox=\"0 0 {0} {1}\">\n",
            width, height);
    }

    void beginLayer(std::size_t index, const std::string& name, const std::string& attributes) {
        add("<g id=\"layer{}\" inkscape:groupmode=\"layer\" inkscape:label=\"{}\"{}>\n", index, name,
            attributes);
    }

    std::string area() const {
        return fmt::format("x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"", number(drawing_.layout.left),
                           number(drawing_.layout.top), number(drawing_.pictureWidth),
                           number(drawing_.pictureHeight));
    }

    Status addBeneath() {
        if (drawing_.raster) {
            MOTE_ASSIGN_OR_RETURN(const auto png, encodePng(*drawing_.raster));
            beginLayer(0, "picture", "");
            add("<image {} preserveAspectRatio=\"none\" image-rendering=\"optimizeSpeed\" "
                "xlink:href=\"data:image/png;base64,{}\"/>\n</g>\n",
                area(), base64(png));
        } else if (drawing_.background != glm::vec3(1.0F)) {
            beginLayer(0, "background", "");
            add("<rect {} fill=\"{}\"/>\n</g>\n", area(), hexColor(drawing_.background));
        }
        return success();
    }

    /// Beyond the picture's edge there is nothing of a stroke.
    void addInks() {
        if (drawing_.inks.empty()) return;
        add("<clipPath id=\"edge\"><rect {}/></clipPath>\n<g clip-path=\"url(#edge)\">\n", area());
        for (std::size_t i = 0; i < drawing_.inks.size(); ++i) addInk(i);
        add("</g>\n");
    }

    void addInk(std::size_t index) {
        const auto& ink = drawing_.inks[index];
        const auto place =
            fmt::format(" transform=\"translate({} {}) scale({:.9g})\"", number(drawing_.layout.left),
                        number(drawing_.layout.top), drawing_.layout.scale / inkUnits);
        beginLayer(index + 1, ink.name, faded("", ink.opacity) + place);
        addInkShapes(ink);
        for (const auto& part : ink.parts) addInkShapes(part);
        add("</g>\n");
    }

    void addInkShapes(const PageInk& ink) {
        add("<g fill=\"{}\" fill-rule=\"evenodd\">\n", hexColor(ink.color));
        for (const auto& outlines : ink.areas) addPaths(outlines, "", "z");
        if (ink.outlines.size() > 0) addPaths(ink.outlines, " fill-rule=\"nonzero\"", "z");
        add("</g>\n<g fill=\"none\" stroke=\"{}\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n",
            hexColor(ink.color));
        for (const auto& [width, lines] : ink.lines)
            addPaths(lines, fmt::format(" stroke-width=\"{}\"", number(width * inkUnits)), "");
        add("</g>\n");
    }

    void addPaths(const PagePaths& paths, const std::string& attributes, const char* end) {
        add("<path{} d=\"", attributes);
        for (std::size_t i = 0; i < paths.size(); ++i) addPath(paths.of(i), end);
        add("\"/>\n");
    }

    /// In whole hundredths of a pixel, all but the first point from the one before.
    void addPath(std::span<const glm::dvec2> points, const char* end) {
        const auto told = [](double pixels) { return std::llround(pixels * inkUnits); };
        auto x = told(points[0].x), y = told(points[0].y);
        add("M{} {}l", x, y);
        for (std::size_t i = 1; i < points.size(); ++i) {
            const auto right = told(points[i].x) - x, down = told(points[i].y) - y;
            if (i > 1 && right >= 0) text_ += ' ';
            add("{}", right);
            if (down >= 0) text_ += ' ';
            add("{}", down);
            x += right;
            y += down;
        }
        if (points.size() == 1) add("0 0");
        text_ += end;
    }

    void addLayer(std::size_t index) {
        const auto& layer = drawing_.layers[index];
        if (drawing_.plotter) {
            beginLayer(drawing_.inks.size() + index + 1, layer.name,
                       " fill=\"none\" stroke-linecap=\"round\"");
            for (const auto& dot : layer.dots) addStroke(dot);
        } else {
            beginLayer(drawing_.inks.size() + index + 1, layer.name, "");
            for (const auto& dot : layer.dots) addCircle(dot);
        }
        add("</g>\n");
    }

    Status addAnnotations() {
        if (drawing_.annotations == nullptr) return success();
        const Typeface typeface;
        MOTE_ASSIGN_OR_RETURN(const auto elements, svgOf(*drawing_.annotations, typeface));
        beginLayer(drawing_.inks.size() + drawing_.layers.size() + 1, "annotations",
                   fmt::format(" transform=\"translate({} {}) scale({:.9g})\"", number(drawing_.layout.left),
                               number(drawing_.layout.top), drawing_.layout.scale));
        text_ += elements + "</g>\n";
        return success();
    }

    /// What is seen of a dot.
    void addPiece(const PageDot& dot) {
        add("<path d=\"");
        for (std::size_t i = 0; i < dot.outline.size(); ++i)
            add("{}{} {}", i == 0 ? "M" : "L", number(dot.x + dot.outline[i].x),
                number(dot.y + dot.outline[i].y));
        add("z\" fill=\"{}\"", hexColor(dot.color));
        text_ += faded("fill-", dot.opacity) + "/>\n";
    }

    void addCircle(const PageDot& dot) {
        if (!dot.outline.empty()) return addPiece(dot);
        add("<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{}\"", number(dot.x), number(dot.y),
            number(dot.radius), hexColor(dot.color));
        text_ += faded("fill-", dot.opacity) + "/>\n";
    }

    void addStroke(const PageDot& dot) {
        add("<path d=\"M{} {}h{}\" stroke=\"{}\" stroke-width=\"{}\"", number(dot.x - 0.5 * dotStroke),
            number(dot.y), number(dotStroke), hexColor(dot.color), number(2.0 * dot.radius));
        text_ += faded("stroke-", dot.opacity) + "/>\n";
    }

    const PageDrawing& drawing_;
    std::string text_;
};

}  // namespace

Result<std::vector<std::uint8_t>> writeSvg(const PageDrawing& drawing) {
    return SvgText(drawing).write();
}

}  // namespace mote::server
