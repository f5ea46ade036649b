// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/readers/sdds_test_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <random>
#include <stdexcept>

namespace mote::test {
namespace {

/// Binary values in the form's byte order.
class Bytes {
  public:
    explicit Bytes(bool big) : big_(big) {}
    template <class Number>
    void number(Number value) {
        char bytes[sizeof(Number)];
        std::memcpy(bytes, &value, sizeof(Number));
        if (big_) std::reverse(std::begin(bytes), std::end(bytes));
        text.append(bytes, sizeof(Number));
    }
    void label(const std::string& value) {
        number(static_cast<std::int32_t>(value.size()));
        text += value;
    }
    std::string text;

  private:
    bool big_;
};

/// Column `column` of a particle, in the order of the header.
void addValue(Bytes& bytes, const SddsParticle& particle, int column) {
    switch (column) {
        case 0:
            return bytes.number(particle.x);
        case 1:
            return bytes.number(static_cast<float>(particle.xp));
        case 2:
            return bytes.label(particle.label);
        case 3:
            return bytes.number(particle.y);
        case 4:
            return bytes.number(particle.yp);
        case 5:
            return bytes.number(particle.mark);
        case 6:
            return bytes.number(particle.t);
        case 7:
            return bytes.number(static_cast<float>(particle.p));
        default:
            return bytes.number(particle.id);
    }
}

void addBinaryPage(std::string& out, const SddsForm& form, const SddsTestPage& page) {
    Bytes bytes(form.big);
    const auto rows = static_cast<std::int32_t>(page.particles.size());
    if (form.wideCount) {
        bytes.number(std::numeric_limits<std::int32_t>::min());
        bytes.number(static_cast<std::int64_t>(rows));
    } else {
        bytes.number(rows);
    }
    bytes.number(page.step);
    if (form.texts) bytes.label(page.title);
    bytes.number(page.charge);
    bytes.number(page.place);
    bytes.number(page.centralMomentum);
    if (form.texts) {
        for (const std::int32_t size : {2, 3}) bytes.number(size);
        for (int i = 0; i < 6; ++i) bytes.label(std::string(static_cast<std::size_t>(i), 'q'));
    }
    for (const std::int32_t size : {3}) bytes.number(size);
    for (const std::int16_t value : {1, 2, 3}) bytes.number(value);
    const auto wanted = [&](int column) { return column != 2 || form.texts; };
    if (form.columnMajor) {
        for (int column = 0; column < 9; ++column) {
            for (const SddsParticle& particle : page.particles) {
                if (wanted(column)) addValue(bytes, particle, column);
            }
        }
    } else {
        for (const SddsParticle& particle : page.particles) {
            for (int column = 0; column < 9; ++column) {
                if (wanted(column)) addValue(bytes, particle, column);
            }
        }
    }
    out += bytes.text;
}

void addAsciiPage(std::string& out, const SddsForm& form, const SddsTestPage& page) {
    const char* comment = form.comments ? "   ! a comment\n! another, \"quoted\n" : "\n";
    out += fmt::format("{}{}", page.step, comment);
    if (form.texts) out += fmt::format("\"{}\"{}", page.title, comment);
    out +=
        fmt::format("{}{}{}{}{}{}", page.charge, comment, page.place, comment, page.centralMomentum, comment);
    if (form.texts) out += fmt::format("2 3{}\"\" q qq\nqqq qqqq \"q q!\\\"q\"{}", comment, comment);
    out += fmt::format("3{}1 2\n3{}", comment, comment);
    if (!form.noRowCounts) out += fmt::format("    {}{}", page.particles.size(), comment);
    for (const SddsParticle& particle : page.particles) {
        out += fmt::format("{} {}", particle.x, static_cast<double>(static_cast<float>(particle.xp)));
        out += form.linesPerRow == 1 ? " " : "\n";
        if (form.texts) out += fmt::format("\"{}\" ", particle.label);
        out += fmt::format("{} {} {} {} {} {}", particle.y, particle.yp, particle.mark, particle.t,
                           static_cast<double>(static_cast<float>(particle.p)), particle.id);
        out += comment;
    }
    if (form.noRowCounts) out += "\n";
}

}  // namespace

std::vector<SddsTestPage> sddsPages(std::uint64_t seed, std::size_t pages, std::size_t rows) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::vector<SddsTestPage> result(pages);
    for (std::size_t i = 0; i < pages; ++i) {
        SddsTestPage& page = result[i];
        page.step = static_cast<std::int32_t>(7 + 3 * i);
        page.charge = 1e-9 * static_cast<double>(i + 1);
        page.place = 1.5 * static_cast<double>(i);
        page.centralMomentum = 200.0;
        page.title = "page " + std::to_string(i);
        for (std::size_t row = 0; row < rows; ++row) {
            SddsParticle particle;
            particle.x = 1e-3 * normal(random);
            particle.xp = static_cast<float>(1e-2 * normal(random));
            particle.y = 2e-3 * normal(random);
            particle.yp = 3e-2 * normal(random);
            particle.t = 5e-9 * static_cast<double>(i) + 1e-12 * normal(random);
            particle.p = static_cast<float>(200.0 + normal(random));
            particle.id = random() | 1u;  // beyond what a double holds
            particle.label = std::string(random() % 5, 'l') + " \xc3\xa9";
            particle.mark = static_cast<char>('a' + random() % 26);
            page.particles.push_back(particle);
        }
    }
    return result;
}

std::string sddsHeader(const SddsForm& form) {
    std::string text = "SDDS5\n";
    if (form.orderInComment) text += form.big ? "!# big-endian\n" : "!# little-endian\n";
    text +=
        "! a comment, \"with a quote\n&description text=\"coordinates, at \\\"W1\\\" &end of it\", "
        "contents=\"elegant\", &end\n"
        "&parameter name=Step, description=\"Simulation step\", type=long, &end\n";
    if (form.texts) text += "&parameter name=Title, type=string &end\n";
    text +=
        "&parameter name=Charge, units=C, type=double, &end\n"
        "&parameter name=Version, type=string, fixed_value=\"1.0 !\", &end\n"
        "&parameter name=s,\n  units=m, ! in two lines\n  type=double, &end\n"
        "&parameter name=pCentral, symbol=\"p$bcen$n\", units=\"m$be$nc\", type=double, &end\n";
    if (form.texts) text += "&array name=words, type=string, dimensions=2 &end\n";
    text += "&array name=Bins, type=short, &end\n";
    text += "&column name=x, units=m, type=double,  &end\n&column name=xp, symbol=\"x'\", type=float &end\n";
    if (form.texts) text += "&column name=label, type=string, &end\n";
    text +=
        "&column name=y, units=m, type=double,  &end\n&column name=yp, symbol=\"y'\", type=double, &end\n"
        "&column name=mark, type=character, &end\n&column name=t, units=s, type=double, &end\n"
        "&column name=p, units=\"m$be$nc\", type=float, &end\n&column name=particleID, type=ulong64, &end\n";
    text += form.ascii ? "&data mode=ascii, " : "&data mode=binary, ";
    if (!form.ascii && !form.orderInComment && !form.orderUnsaid)
        text += form.big ? "endian=big, " : "endian=little, ";
    if (form.columnMajor) text += "column_major_order=1, ";
    if (form.noRowCounts) text += "no_row_counts=1, ";
    if (form.linesPerRow != 1) text += fmt::format("lines_per_row={}, ", form.linesPerRow);
    if (form.additionalLines > 0) text += fmt::format("additional_header_lines={}, ", form.additionalLines);
    text += "&end\n";
    for (int i = 0; i < form.additionalLines; ++i) text += "any text &column\n";
    return text;
}

std::string sddsFile(const SddsForm& form, const std::vector<SddsTestPage>& pages) {
    std::string text = sddsHeader(form);
    for (const SddsTestPage& page : pages) {
        form.ascii ? addAsciiPage(text, form, page) : addBinaryPage(text, form, page);
    }
    return text;
}

}  // namespace mote::test
