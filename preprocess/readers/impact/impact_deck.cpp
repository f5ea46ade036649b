// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/impact/impact_deck.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <system_error>
#include <vector>

#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"

namespace mote::prep {
namespace {

constexpr std::size_t maxValues = 64;  // of one read or one element
constexpr std::size_t maxChargeStates = 1000;
constexpr std::uint64_t maxLines = 10'000'000;
constexpr int dumpElement = -2;
constexpr int haltElement = -99;

/// The deck as a sequence of Fortran list-directed reads.
class DeckReader {
  public:
    explicit DeckReader(LineReader lines) : lines_(std::move(lines)) {}

    /// `count` values, from as many lines as they take; fewer where '/' ends them early (they are 0 then).
    Result<std::vector<double>> values(std::size_t count, const char* what);
    /// The values of one line; nothing at the end of the deck.
    Result<std::optional<std::vector<double>>> line();
    std::string where() const { return lines_.name() + ": line " + std::to_string(lines_.lineNumber()); }

  private:
    /// Appends the values of a line; whether '/' ended them.
    bool append(std::string_view text, std::size_t limit, std::vector<double>& values) const;
    Result<bool> nextLine(std::string_view& text);

    LineReader lines_;
};

Result<bool> DeckReader::nextLine(std::string_view& text) {
    while (lines_.lineNumber() < maxLines) {
        const auto more = lines_.next(text);
        if (!more || !*more) return more;
        text = trim(text.substr(0, text.find('!')));
        if (!text.empty()) return true;
    }
    return false;
}

bool DeckReader::append(std::string_view text, std::size_t limit, std::vector<double>& values) const {
    const std::size_t slash = text.find('/');
    std::array<std::string_view, maxValues> fields;
    const std::size_t count = std::min(splitFields(text.substr(0, slash), ' ', fields), maxValues);
    for (std::size_t i = 0; i < count && values.size() < limit; ++i) {
        std::string_view field = fields[i];
        std::size_t repeat = 1;  // "3*0.0" stands for three values
        if (const std::size_t star = field.find('*'); star != std::string_view::npos && star > 0) {
            repeat = static_cast<std::size_t>(parseId(field.substr(0, star)).value_or(1));
            field = field.substr(star + 1);
        }
        const auto value = parseNumber(field);
        if (!value) break;  // text behind the values
        for (; repeat > 0 && values.size() < limit; --repeat) values.push_back(*value);
    }
    return slash != std::string_view::npos;
}

Result<std::vector<double>> DeckReader::values(std::size_t count, const char* what) {
    std::vector<double> result;
    while (result.size() < count) {
        std::string_view text;
        MOTE_ASSIGN_OR_RETURN(const auto more, nextLine(text));
        if (!more) return corrupt(where(), std::string("the deck ends before ") + what);
        const std::size_t before = result.size();
        if (append(text, count, result)) break;
        if (result.size() == before) {
            return corrupt(where(), std::string("has no numbers where ") + what + " should stand");
        }
    }
    result.resize(count, 0.0);
    return result;
}

Result<std::optional<std::vector<double>>> DeckReader::line() {
    std::string_view text;
    MOTE_ASSIGN_OR_RETURN(const auto more, nextLine(text));
    if (!more) return std::optional<std::vector<double>>();
    std::vector<double> values;
    append(text, maxValues, values);
    return std::optional<std::vector<double>>(std::move(values));
}

Status readReference(DeckReader& reader, ImpactDeck& deck) {
    MOTE_ASSIGN_OR_RETURN(const auto values,
                          reader.values(6, "the line of current, energy, mass, charge, frequency and phase"));
    deck.current = values[0];
    deck.kineticEnergy = values[1];
    deck.mass = values[2];
    deck.charge = values[3];
    deck.frequency = values[4];
    const bool sane = deck.mass > 0.0 && std::isfinite(deck.mass) && deck.kineticEnergy >= 0.0 &&
                      std::isfinite(deck.kineticEnergy) && deck.frequency > 0.0 &&
                      std::isfinite(deck.frequency);
    if (sane) return success();
    return corrupt(reader.where(), "needs a mass and a frequency above 0 and an energy of at least 0");
}

Status skip(DeckReader& reader, std::initializer_list<std::size_t> reads) {
    for (const std::size_t count : reads) {
        MOTE_ASSIGN_OR_RETURN(const auto values, reader.values(count, "the line of the reference particle"));
    }
    return success();
}

Status readImpactZ(DeckReader& reader, ImpactDeck& deck) {
    MOTE_RETURN_IF_ERROR(skip(reader, {2}));
    MOTE_ASSIGN_OR_RETURN(const auto sizes, reader.values(2, "the number of particles"));
    deck.particles = sizes[1];
    MOTE_RETURN_IF_ERROR(skip(reader, {7}));
    MOTE_ASSIGN_OR_RETURN(const auto start, reader.values(4, "the number of charge states"));
    const double states = start[3];
    if (!(states >= 1.0 && states <= static_cast<double>(maxChargeStates))) {
        return corrupt(reader.where(), "has an impossible number of charge states");
    }
    const auto perState = static_cast<std::size_t>(states);
    return skip(reader, {perState, perState, perState, 7, 7, 7});
}

Status readImpactT(DeckReader& reader, ImpactDeck& deck) {
    MOTE_RETURN_IF_ERROR(skip(reader, {2, 3}));
    MOTE_ASSIGN_OR_RETURN(const auto sizes, reader.values(2, "the number of particles"));
    deck.particles = sizes[1];
    return skip(reader, {7, 4, 7, 7, 7});
}

/// Walks the elements of the lattice, adding their lengths, and keeps where particle files were written.
Status readDumps(DeckReader& reader, ImpactDeck& deck) {
    double path = 0.0;
    while (true) {
        MOTE_ASSIGN_OR_RETURN(const auto element, reader.line());
        if (!element || element->size() < 4) return success();
        const double length = (*element)[0], file = (*element)[2], type = (*element)[3];
        if (type == haltElement) return success();
        if (type == dumpElement && file == std::floor(file) && std::abs(file) < 1e9) {
            deck.dumps[static_cast<std::int64_t>(file)] = path;
        }
        if (type >= 0 && std::isfinite(length)) path += length;
    }
}

constexpr std::size_t maxPoints = 20'000'000;

}  // namespace

std::optional<std::filesystem::path> fileBeside(const std::filesystem::path& file, std::string_view name) {
    for (const char* ending : {"", ".txt", ".gz", ".txt.gz"}) {
        std::filesystem::path candidate = file.parent_path() / (std::string(name) + ending);
        std::error_code code;
        if (std::filesystem::is_regular_file(candidate, code) && !code) return candidate;
    }
    return std::nullopt;
}

std::optional<std::filesystem::path> ImpactDeck::beside(const std::filesystem::path& file, Code code) {
    return fileBeside(file, code == Code::impactZ ? "ImpactZ.in" : "ImpactT.in");
}

Result<ImpactDeck> ImpactDeck::read(const std::filesystem::path& path, Code code) {
    MOTE_ASSIGN_OR_RETURN(auto lines, LineReader::open(path));
    DeckReader reader(std::move(lines));
    ImpactDeck deck;
    MOTE_RETURN_IF_ERROR(code == Code::impactZ ? readImpactZ(reader, deck) : readImpactT(reader, deck));
    MOTE_RETURN_IF_ERROR(readReference(reader, deck));
    if (code == Code::impactZ) MOTE_RETURN_IF_ERROR(readDumps(reader, deck));
    return deck;
}

ReferenceTrack::Point ReferenceTrack::at(double path) const {
    const auto after =
        std::upper_bound(points.begin(), points.end(), path,
                         [](double wanted, const Point& point) { return wanted < point.path; });
    if (after == points.begin()) return points.front();
    const Point& left = *std::prev(after);
    if (after == points.end()) return left;
    const double part = (path - left.path) / (after->path - left.path);
    return {path, left.phase + part * (after->phase - left.phase),
            left.gamma + part * (after->gamma - left.gamma)};
}

Result<ReferenceTrack> ReferenceTrack::read(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(auto reader, LineReader::open(path));
    ReferenceTrack track;
    for (std::string_view line;;) {
        MOTE_ASSIGN_OR_RETURN(const auto more, reader.next(line));
        if (!more) break;
        if (!isRow(line)) continue;
        std::array<std::string_view, 3> fields;
        const std::size_t count = splitFields(line, ' ', fields);
        std::array<double, 3> values{};
        for (std::size_t i = 0; i < 3; ++i) {
            const auto value = i < count ? parseNumber(fields[i]) : std::nullopt;
            if (!value || !std::isfinite(*value) || (i == 2 && *value < 1.0)) {
                return corrupt(reader.name() + ": line " + std::to_string(reader.lineNumber()),
                               "does not begin with path, phase and gamma");
            }
            values[i] = *value;
        }
        if (!track.points.empty() && values[0] < track.points.back().path) track.points.clear();
        if (track.points.size() >= maxPoints) {
            return Error{ErrorCode::resourceExhausted, reader.name(), "has more than 20 million lines"};
        }
        track.points.push_back({values[0], values[1], values[2]});
    }
    if (track.points.empty()) return corrupt(reader.name(), "holds no reference particle");
    return track;
}

}  // namespace mote::prep
