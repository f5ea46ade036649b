// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/typeface.h"

#include <ft2build.h>
#include FT_FREETYPE_H
#include FT_OUTLINE_H

#include <span>

#include "protocol/base/mote_check.h"
#include "protocol/base/utf8.h"
#include "server/figures/embedded_fonts.h"

namespace mote::server {
namespace {

constexpr FT_Int32 asDrawn = FT_LOAD_NO_SCALE | FT_LOAD_NO_HINTING | FT_LOAD_NO_BITMAP;

/// Of a character's bytes, which characterLength() has measured.
char32_t codePoint(std::string_view bytes) {
    const auto first = static_cast<unsigned char>(bytes[0]);
    if (bytes.size() == 1) return first;
    char32_t code = first & (0xffU >> (bytes.size() + 1));
    for (const char c : bytes.substr(1)) code = (code << 6) | (static_cast<unsigned char>(c) & 0x3fU);
    return code;
}

/// Characters that are never seen themselves: marks of direction, joiners, and control characters.
bool steers(char32_t code) {
    return code < 0x20 || (code >= 0x7f && code < 0xa0) || code == 0xad || code == 0x61c ||
           (code >= 0x200b && code <= 0x200f) || (code >= 0x2028 && code <= 0x202e) ||
           (code >= 0x2060 && code <= 0x206f) || code == 0xfeff || (code >= 0xfe00 && code <= 0xfe0f) ||
           (code >= 0xe0000 && code <= 0xe0fff);
}

/// Collects an outline; FreeType calls these with its own units, y up.
struct Collector {
    GlyphOutline outline;
    glm::dvec2 at{0.0};
    double scale;

    glm::dvec2 place(const FT_Vector* v) const {
        return {static_cast<double>(v->x) * scale, -static_cast<double>(v->y) * scale};
    }
    void add(const glm::dvec2& first, const glm::dvec2& second, const glm::dvec2& end) {
        auto& curves = outline.contours.back().curves;
        curves.insert(curves.end(), {first, second, end});
        at = end;
    }
    static int move(const FT_Vector* to, void* user) {
        auto& self = *static_cast<Collector*>(user);
        self.at = self.place(to);
        self.outline.contours.push_back({self.at, {}});
        return 0;
    }
    static int line(const FT_Vector* to, void* user) {
        auto& self = *static_cast<Collector*>(user);
        self.add(self.at, self.place(to), self.place(to));
        return 0;
    }
    static int conic(const FT_Vector* bend, const FT_Vector* to, void* user) {
        auto& self = *static_cast<Collector*>(user);
        const glm::dvec2 middle = self.place(bend), end = self.place(to);
        self.add((self.at + 2.0 * middle) / 3.0, (end + 2.0 * middle) / 3.0, end);
        return 0;
    }
    static int cubic(const FT_Vector* first, const FT_Vector* second, const FT_Vector* to, void* user) {
        auto& self = *static_cast<Collector*>(user);
        self.add(self.place(first), self.place(second), self.place(to));
        return 0;
    }
};

double unitsOf(FT_Face face) {
    return 1.0 / face->units_per_EM;
}

}  // namespace

struct Typeface::Library {
    FT_Library handle = nullptr;
    Library() { MOTE_CHECK(FT_Init_FreeType(&handle) == 0); }
    ~Library() { FT_Done_FreeType(handle); }
    Library(const Library&) = delete;
    Library& operator=(const Library&) = delete;
};

Typeface::Typeface() : library_(std::make_shared<Library>()) {
    const std::span<const unsigned char> files[] = {uprightFont, italicFont};
    for (int i = 0; i < 2; ++i) {
        FT_Face face = nullptr;
        MOTE_CHECK(FT_New_Memory_Face(library_->handle, files[i].data(),
                                      static_cast<FT_Long>(files[i].size()), 0, &face) == 0);
        faces_[i] = {face, [library = library_](FT_Face done) { FT_Done_Face(done); }};
    }
}

Typeface::~Typeface() = default;

std::shared_ptr<FT_FaceRec_> Typeface::face(bool italic) const {
    return faces_[italic ? 1 : 0];
}

TextLine Typeface::layOut(const RichText& text, double size) const {
    TextLine line;
    for (const auto& run : text) {
        const FT_Face face = faces_[run.italic ? 1 : 0].get();
        const double own = run.script == Script::normal ? size : scriptSize * size;
        const double shift = run.script == Script::normal  ? 0.0
                             : run.script == Script::above ? -raise * size
                                                           : lower * size;
        FT_UInt before = 0;
        for (std::string_view left = run.text; !left.empty();) {
            const std::size_t length = characterLength(left);
            const std::string_view bytes = left.substr(0, std::max<std::size_t>(length, 1));
            left.remove_prefix(bytes.size());
            const char32_t code = length > 0 ? codePoint(bytes) : U'?';
            if (steers(code)) continue;
            const FT_UInt index = FT_Get_Char_Index(face, code);
            FT_Vector kerning{0, 0};
            if (before != 0 && index != 0) FT_Get_Kerning(face, before, index, FT_KERNING_UNSCALED, &kerning);
            FT_Fixed advance = 0;
            if (FT_Load_Glyph(face, index, asDrawn) == 0) advance = face->glyph->metrics.horiAdvance;
            line.width += static_cast<double>(kerning.x) * unitsOf(face) * own;
            line.glyphs.push_back({index, run.italic, own, {line.width, shift}, bytes});
            line.width += static_cast<double>(advance) * unitsOf(face) * own;
            before = index;
        }
    }
    return line;
}

const GlyphOutline& Typeface::outline(const PlacedGlyph& glyph) const {
    const auto [found, isNew] = outlines_.try_emplace({glyph.italic, glyph.index});
    if (!isNew) return found->second;
    const FT_Face face = faces_[glyph.italic ? 1 : 0].get();
    if (FT_Load_Glyph(face, glyph.index, asDrawn) != 0) return found->second;
    Collector collector{{}, {}, unitsOf(face)};
    FT_Outline_Funcs calls{};
    calls.move_to = Collector::move;
    calls.line_to = Collector::line;
    calls.conic_to = Collector::conic;
    calls.cubic_to = Collector::cubic;
    if (FT_Outline_Decompose(&face->glyph->outline, &calls, &collector) == 0)
        found->second = std::move(collector.outline);
    return found->second;
}

}  // namespace mote::server
