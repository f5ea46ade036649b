// SPDX-License-Identifier: GPL-3.0-or-later
//
// BpFile: an ADIOS2 file (BP4, BP5), read by ADIOS2's own library. That comes with some sixty others, so it
// is a module of its own (bp_module.cpp), which a job loads when it is given such a file and which need not
// be there. Between the two stand the standard library's types alone. Owned by a BpTree; one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace mote::prep {

struct BpAttribute {
    std::string name;  ///< "/data/100/time"
    std::variant<std::vector<double>, std::vector<std::int64_t>, std::vector<std::uint64_t>,
                 std::vector<std::string>>
        values;
};

/// A step of a variable of plain numbers.
struct BpVariable {
    enum class Kind : std::uint8_t { integer, natural, real };

    std::string name;  ///< "/data/100/particles/e/position/x"
    Kind kind = Kind::real;
    std::size_t valueBytes = 8;
    std::vector<std::uint64_t> extent;  ///< none of a single value
    std::size_t step = 0;               ///< of those that have the variable
};

struct BpContents {
    std::vector<BpVariable> variables;
    std::vector<BpAttribute> attributes;
};

/// Its functions throw std::bad_alloc, and else return what is wrong, a part of a sentence; "" if all is
/// well.
class BpFile {
  public:
    static constexpr std::size_t mostNames = 1'000'000, mostSteps = 100'000, mostElements = 4096;

    virtual ~BpFile() = default;
    /// All that it holds: the last step of each variable, and each attribute as it was last.
    virtual std::string contents(BpContents& all) = 0;
    /// The same by steps, with the attributes as they are in each.
    virtual std::string contentsByStep(std::vector<BpContents>& steps) = 0;
    /// How many values were written of a variable, all of them within its extent.
    virtual std::string countValues(const BpVariable& variable, std::uint64_t& count) = 0;
    /// A box of its values, as they are stored but in this machine's order of bytes.
    virtual std::string read(const BpVariable& variable, std::span<const std::size_t> first,
                             std::span<const std::size_t> count, void* values) = 0;
};

/// What opens a folder; null, with the reason, where it cannot.
using OpenBp = BpFile* (*)(const char* folder, bool bp5, std::string& why);

/// What the module calls it.
inline constexpr const char* openBpName = "moteOpenBp";

/// Of the module beside the program, or where it is installed; null: it is not there.
OpenBp openBp();

}  // namespace mote::prep
