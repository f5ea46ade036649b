// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/draw_marks.h"

#include <cairo-ft.h>

#include <memory>
#include <string>

#include "server/figures/cairo_surface.h"

namespace mote::server {
namespace {

constexpr double dash = 3.0;       // of a dashed line, widths; as long as the gap
constexpr double haloWidth = 0.3;  // em, all of it

struct DestroyFontFace {
    void operator()(cairo_font_face_t* face) const { cairo_font_face_destroy(face); }
};
using FontFace = std::unique_ptr<cairo_font_face_t, DestroyFontFace>;

/// Cairo may keep it longer than any drawing: it shares the file.
FontFace fontFace(const Typeface& typeface, bool italic) {
    static const cairo_user_data_key_t key{};
    auto* const shared = new std::shared_ptr<FT_FaceRec_>(typeface.face(italic));
    FontFace face(cairo_ft_font_face_create_for_ft_face(shared->get(), FT_LOAD_NO_HINTING));
    const auto destroy = [](void* user) { delete static_cast<std::shared_ptr<FT_FaceRec_>*>(user); };
    if (cairo_font_face_set_user_data(face.get(), &key, shared, destroy) != CAIRO_STATUS_SUCCESS)
        delete shared;
    return face;
}

void setInk(cairo_t* context, const Ink& ink) {
    cairo_set_source_rgba(context, ink.color.x, ink.color.y, ink.color.z, ink.opacity);
}

void addWay(cairo_t* context, const std::vector<glm::dvec2>& points) {
    for (const auto& point : points) cairo_line_to(context, point.x, point.y);
}

class MarkDrawer {
  public:
    MarkDrawer(cairo_t* context, const Typeface& typeface, TextAs textAs)
        : context_(context), typeface_(typeface), textAs_(textAs) {}

    void operator()(const LineMark& line) {
        setInk(context_, line.ink);
        cairo_set_line_width(context_, line.width);
        const double gap = dash * line.width;
        cairo_set_dash(context_, &gap, line.dashed ? 1 : 0, 0.0);
        cairo_new_path(context_);
        addWay(context_, line.points);
        if (line.closed) cairo_close_path(context_);
        cairo_stroke(context_);
    }
    void operator()(const AreaMark& area) {
        setInk(context_, area.ink);
        cairo_new_path(context_);
        addWay(context_, area.points);
        cairo_fill(context_);
    }
    void operator()(const ImageMark& image);
    void operator()(const TextMark& text) {
        const auto line = typeface_.layOut(text.text, text.size);
        cairo_save(context_);
        cairo_translate(context_, text.place.x, text.place.y);
        cairo_rotate(context_, text.angle);
        cairo_translate(context_, -text.anchor.x * line.width,
                        (1.0 - text.anchor.y) * Typeface::capHeight * text.size);
        if (text.halo.opacity > 0.0) {
            addOutlines(line);
            setInk(context_, text.halo);
            cairo_set_dash(context_, nullptr, 0, 0.0);
            cairo_set_line_width(context_, haloWidth * text.size);
            // Nobody sees how round it is, and it would cost more than all else.
            cairo_save(context_);
            cairo_set_antialias(context_, CAIRO_ANTIALIAS_FAST);
            cairo_set_tolerance(context_, 0.5);
            cairo_stroke(context_);
            cairo_restore(context_);
        }
        setInk(context_, text.ink);
        if (textAs_ == TextAs::text) {
            showText(line);
        } else {
            addOutlines(line);
            cairo_fill(context_);
        }
        cairo_restore(context_);
    }

  private:
    void addOutlines(const TextLine& line) {
        cairo_new_path(context_);
        for (const auto& glyph : line.glyphs) {
            for (const auto& contour : typeface_.outline(glyph).contours) {
                const auto at = [&](const glm::dvec2& place) { return glyph.place + glyph.size * place; };
                const auto begin = at(contour.begin);
                cairo_move_to(context_, begin.x, begin.y);
                for (std::size_t i = 0; i + 2 < contour.curves.size(); i += 3) {
                    const auto a = at(contour.curves[i]), b = at(contour.curves[i + 1]),
                               c = at(contour.curves[i + 2]);
                    cairo_curve_to(context_, a.x, a.y, b.x, b.y, c.x, c.y);
                }
                cairo_close_path(context_);
            }
        }
    }
    /// Glyphs of one font and size at a time.
    void showText(const TextLine& line) {
        for (std::size_t begin = 0; begin < line.glyphs.size();) {
            const auto& first = line.glyphs[begin];
            std::vector<cairo_glyph_t> glyphs;
            std::vector<cairo_text_cluster_t> clusters;
            std::string source;
            std::size_t end = begin;
            for (; end < line.glyphs.size() && line.glyphs[end].italic == first.italic &&
                   line.glyphs[end].size == first.size;
                 ++end) {
                const auto& glyph = line.glyphs[end];
                glyphs.push_back({glyph.index, glyph.place.x, glyph.place.y});
                const bool valid =
                    glyph.source.size() > 1 || static_cast<unsigned char>(glyph.source[0]) < 0x80;
                source += valid ? glyph.source : "?";
                clusters.push_back({valid ? static_cast<int>(glyph.source.size()) : 1, 1});
            }
            auto& face = faces_[first.italic ? 1 : 0];
            if (face == nullptr) face = fontFace(typeface_, first.italic);
            cairo_set_font_face(context_, face.get());
            cairo_set_font_size(context_, first.size);
            cairo_show_text_glyphs(context_, source.data(), static_cast<int>(source.size()), glyphs.data(),
                                   static_cast<int>(glyphs.size()), clusters.data(),
                                   static_cast<int>(clusters.size()), {});
            begin = end;
        }
    }

    cairo_t* const context_;
    const Typeface& typeface_;
    const TextAs textAs_;
    FontFace faces_[2];
};

void MarkDrawer::operator()(const ImageMark& image) {
    const auto surface = surfaceOf(image);
    cairo_save(context_);
    cairo_rectangle(context_, image.box.low.x, image.box.low.y, image.box.size().x, image.box.size().y);
    cairo_clip(context_);
    cairo_translate(context_, image.box.low.x, image.box.low.y);
    cairo_scale(context_, image.box.size().x / image.width, image.box.size().y / image.height);
    cairo_set_source_surface(context_, surface.get(), 0.0, 0.0);
    cairo_pattern_set_filter(cairo_get_source(context_), CAIRO_FILTER_NEAREST);
    cairo_paint(context_);
    cairo_restore(context_);
}

}  // namespace

void drawMarks(cairo_t* context, const Marks& marks, const Typeface& typeface, TextAs textAs) {
    cairo_save(context);
    cairo_set_line_join(context, CAIRO_LINE_JOIN_ROUND);
    MarkDrawer drawer(context, typeface, textAs);
    for (const auto& mark : marks) std::visit([&](const auto& of) { drawer(of); }, mark);
    cairo_restore(context);
}

Marks flattened(Marks marks, const glm::dvec3& background) {
    const auto flatten = [&](Ink& ink) {
        ink = {ink.color * ink.opacity + background * (1.0 - ink.opacity), ink.opacity > 0.0 ? 1.0 : 0.0};
    };
    for (auto& mark : marks) {
        if (auto* line = std::get_if<LineMark>(&mark)) flatten(line->ink);
        if (auto* area = std::get_if<AreaMark>(&mark)) flatten(area->ink);
        if (auto* text = std::get_if<TextMark>(&mark)) {
            flatten(text->ink);
            flatten(text->halo);
        }
    }
    return marks;
}

}  // namespace mote::server
