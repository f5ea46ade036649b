// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

namespace mote::test {

std::string Verdict::toLine() const {
    std::string sentence = text;
    std::replace(sentence.begin(), sentence.end(), '\n', ' ');
    // Streams do not read infinity.
    return fmt::format("verdict {} {:.4f} {} {:.6f} {} {} {:.6f} {:.6f} {} {}", static_cast<int>(kind),
                       std::min(psnr, 999.0), worst, doubtful, blank ? 1 : 0, samples, referenceSeconds,
                       deviceSeconds, pictures, sentence);
}

Result<Verdict> Verdict::parse(const std::string& line) {
    std::istringstream stream(line);
    std::string word;
    int kind = 0;
    Verdict verdict;
    stream >> word >> kind >> verdict.psnr >> verdict.worst >> verdict.doubtful >> verdict.blank >>
        verdict.samples >> verdict.referenceSeconds >> verdict.deviceSeconds >> verdict.pictures;
    if (!stream || word != "verdict" || kind < 0 || kind > static_cast<int>(Kind::dead))
        return Error{ErrorCode::invalidArgument, "verdict", "is no verdict: " + line};
    verdict.kind = static_cast<Kind>(kind);
    if (verdict.psnr >= 999.0) verdict.psnr = std::numeric_limits<double>::infinity();
    stream.get();
    std::getline(stream, verdict.text);
    return verdict;
}

}  // namespace mote::test
