// SPDX-License-Identifier: GPL-3.0-or-later
#include <adios2.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <limits>
#include <map>
#include <new>

#include "preprocess/readers/adios2/bp_file.h"

namespace mote::prep {
namespace {

using Numbers = adios2::VariableNT;

/// What of an exception's text is for people: without colours, dates and places in the library.
std::string plainReason(std::string_view what) {
    what = what.substr(0, what.find_first_of("\n\r"));
    const auto begin = what.rfind("> : ");
    if (begin != std::string_view::npos) what.remove_prefix(begin + 4);
    what = what.substr(0, what.find('\x1b'));
    return "ADIOS2 cannot read it: " + std::string(what);
}

std::atomic<int> reading = 0;  ///< calls of ADIOS2 that are under way

/// Counts in `reading` while it lives.
struct Reading {
    Reading() { ++reading; }
    ~Reading() { --reading; }
};

/// Calls `act`; what ADIOS2 throws is told.
template <class Act>
std::string told(Act act) {
    const Reading here;
    try {
        return act();
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& failure) {
        return plainReason(failure.what());
    }
}

struct NumberType {
    const char* name;
    BpVariable::Kind kind;
    std::size_t bytes;
};

using Kind = BpVariable::Kind;
constexpr std::array numberTypes{
    NumberType{"int8_t", Kind::integer, 1},   NumberType{"int16_t", Kind::integer, 2},
    NumberType{"int32_t", Kind::integer, 4},  NumberType{"int64_t", Kind::integer, 8},
    NumberType{"char", Kind::integer, 1},     NumberType{"uint8_t", Kind::natural, 1},
    NumberType{"uint16_t", Kind::natural, 2}, NumberType{"uint32_t", Kind::natural, 4},
    NumberType{"uint64_t", Kind::natural, 8}, NumberType{"float", Kind::real, sizeof(float)},
    NumberType{"double", Kind::real, 8},      NumberType{"long double", Kind::real, sizeof(long double)}};

/// Whether the attribute's type is T, and what it holds then.
template <class T, class Wide>
bool readAttributeAs(adios2::IO& io, const std::string& type, BpAttribute& attribute) {
    if (type != adios2::GetType<T>()) return false;
    const auto values = io.InquireAttribute<T>(attribute.name).Data();
    attribute.values = std::vector<Wide>(values.begin(), values.end());
    return values.size() <= BpFile::mostElements;
}

/// False for what is neither number nor text, and for longer lists than any that openPMD has.
bool readBpAttribute(adios2::IO& io, BpAttribute& attribute) {
    const auto type = io.AttributeType(attribute.name);
    return readAttributeAs<std::string, std::string>(io, type, attribute) ||
           readAttributeAs<double, double>(io, type, attribute) ||
           readAttributeAs<float, double>(io, type, attribute) ||
           readAttributeAs<long double, double>(io, type, attribute) ||
           readAttributeAs<std::int8_t, std::int64_t>(io, type, attribute) ||
           readAttributeAs<std::int16_t, std::int64_t>(io, type, attribute) ||
           readAttributeAs<std::int32_t, std::int64_t>(io, type, attribute) ||
           readAttributeAs<std::int64_t, std::int64_t>(io, type, attribute) ||
           readAttributeAs<char, std::int64_t>(io, type, attribute) ||
           readAttributeAs<std::uint8_t, std::uint64_t>(io, type, attribute) ||
           readAttributeAs<std::uint16_t, std::uint64_t>(io, type, attribute) ||
           readAttributeAs<std::uint32_t, std::uint64_t>(io, type, attribute) ||
           readAttributeAs<std::uint64_t, std::uint64_t>(io, type, attribute);
}

/// False for what holds no plain numbers in one place: structures, complex numbers, arrays that each writer
/// has for itself.
bool describeVariable(const Numbers& variable, BpVariable& described) {
    const auto* const type =
        std::find_if(numberTypes.begin(), numberTypes.end(),
                     [&](const NumberType& known) { return variable.Type() == known.name; });
    const auto shape = variable.ShapeID();
    if (type == numberTypes.end() || shape == adios2::ShapeID::LocalArray ||
        shape == adios2::ShapeID::LocalValue || shape == adios2::ShapeID::Unknown) {
        return false;
    }
    described.kind = type->kind;
    described.valueBytes = type->bytes;
    return true;
}

/// How many values the blocks hold; beyond the extent, none.
template <class Blocks>
std::string countIn(const Blocks& blocks, const BpVariable& variable, std::uint64_t& count) {
    for (const auto& block : blocks) {
        if (block.Start.size() != variable.extent.size() || block.Count.size() != variable.extent.size()) {
            return "has blocks of another number of dimensions; the file is damaged";
        }
        std::uint64_t values = 1;
        for (std::size_t i = 0; i < block.Count.size(); ++i) {
            const auto room =
                variable.extent[i] - std::min<std::uint64_t>(block.Start[i], variable.extent[i]);
            if (block.Count[i] > room) return "has blocks beyond its extent; the file is damaged";
            values *= block.Count[i];  // of an extent whose product is known to be small
        }
        count = values > std::numeric_limits<std::uint64_t>::max() - count
                    ? std::numeric_limits<std::uint64_t>::max()
                    : count + values;
    }
    return "";
}

class AdiosFile : public BpFile {
  public:
    AdiosFile(const char* folder, bool bp5) : folder_(folder), bp5_(bp5), io_(declare("all")) {
        engine_ = io_.Open(folder_, adios2::Mode::ReadRandomAccess);
    }
    AdiosFile(const AdiosFile&) = delete;
    AdiosFile& operator=(const AdiosFile&) = delete;
    ~AdiosFile() override {
        if (engine_)
            std::ignore = told([&] {
                engine_.Close();
                return std::string();
            });
    }

    std::string contents(BpContents& all) override {
        return told([&]() -> std::string {
            for (const auto& [name, unused] : io_.AvailableVariables(true)) {
                const auto variable = io_.InquireVariable(name);
                BpVariable described{.name = name, .extent = {}};
                if (!variable || !describeVariable(variable, described) || variable.Steps() == 0) continue;
                described.step = variable.Steps() - 1;
                // BP4 tells the last one's extent alone, and by no step.
                const auto extent = bp5_ ? variable.Shape(described.step) : variable.Shape();
                described.extent.assign(extent.begin(), extent.end());
                all.variables.push_back(std::move(described));
            }
            return addAttributes(io_, all);
        });
    }

    std::string contentsByStep(std::vector<BpContents>& steps) override {
        return told([&]() -> std::string {
            auto io = declare("steps");
            // BP4 would take all attributes as they are at the end.
            io.SetParameter("StreamReader", "On");
            auto engine = io.Open(folder_, adios2::Mode::Read);
            std::map<std::string, std::size_t> seen;
            std::string why;
            while (why.empty() && engine.BeginStep(adios2::StepMode::Read, 0.0F) == adios2::StepStatus::OK) {
                if (steps.size() >= mostSteps) why = "has more than 100000 steps";
                why = why.empty() ? addStep(io, seen, steps.emplace_back()) : why;
                engine.EndStep();
            }
            engine.Close();
            return why;
        });
    }

    std::string countValues(const BpVariable& variable, std::uint64_t& count) override {
        return told([&]() -> std::string {
            auto numbers = io_.InquireVariable(variable.name);
            if (!numbers) return "has changed since it was opened";
            // By absolute steps in BP4, by the variable's own in BP5; in their order in both.
            const auto all = engine_.AllStepsBlocksInfo(numbers);
            if (variable.step >= all.size()) return "lacks a step; the file is damaged";
            const auto& blocks = std::next(all.begin(), static_cast<std::ptrdiff_t>(variable.step))->second;
            count = 0;
            if (!variable.extent.empty()) return countIn(blocks, variable, count);
            count = blocks.empty() ? 0 : 1;
            return "";
        });
    }

    std::string read(const BpVariable& variable, std::span<const std::size_t> first,
                     std::span<const std::size_t> count, void* values) override {
        return told([&]() -> std::string {
            auto numbers = io_.InquireVariable(variable.name);
            if (!numbers) return "has changed since it was opened";
            numbers.SetStepSelection({variable.step, 1});
            if (!variable.extent.empty()) {
                numbers.SetSelection({{first.begin(), first.end()}, {count.begin(), count.end()}});
            }
            engine_.Get(numbers, values, adios2::Mode::Sync);
            return "";
        });
    }

  private:
    adios2::IO declare(const char* name) {
        auto io = adios_.DeclareIO(name);
        io.SetEngine(bp5_ ? "BP5" : "BP4");
        io.SetParameters({{"OpenTimeoutSecs", "0"}, {"Threads", "1"}});
        return io;
    }

    static std::string addAttributes(adios2::IO& io, BpContents& contents) {
        const auto all = io.AvailableAttributes();
        if (all.size() > mostNames || contents.variables.size() > mostNames)
            return "holds more than a million names";
        for (const auto& [name, unused] : all) {
            BpAttribute attribute{name, {}};
            if (readBpAttribute(io, attribute)) contents.attributes.push_back(std::move(attribute));
        }
        return "";
    }

    static std::string addStep(adios2::IO& io, std::map<std::string, std::size_t>& seen, BpContents& step) {
        for (const auto& [name, unused] : io.AvailableVariables(true)) {
            const auto variable = io.InquireVariable(name);
            if (!variable) continue;
            BpVariable described{.name = name, .extent = {}};
            described.step = seen[name]++;
            if (!describeVariable(variable, described)) continue;
            const auto extent = variable.Shape();
            described.extent.assign(extent.begin(), extent.end());
            step.variables.push_back(std::move(described));
        }
        return addAttributes(io, step);
    }

    std::string folder_;
    bool bp5_;
    adios2::ADIOS adios_;
    adios2::IO io_;
    adios2::Engine engine_;
};

}  // namespace

/// What ADIOS2 calls for read(2), for this module is loaded so that its own names go before all others:
/// ADIOS2 2.10 reads on for ever where a file ends too early, and is told of an error there.
extern "C" ssize_t readToTheEnd(int descriptor, void* bytes, std::size_t count) __asm__("read");
extern "C" ssize_t readToTheEnd(int descriptor, void* bytes, std::size_t count) {
    const auto got = syscall(SYS_read, descriptor, bytes, count);
    if (got != 0 || count == 0 || reading == 0) return got;
    errno = ENODATA;
    return -1;
}

extern "C" BpFile* moteOpenBp(const char* folder, bool bp5, std::string& why) {
    BpFile* file = nullptr;
    why = told([&] {
        file = new AdiosFile(folder, bp5);
        return std::string();
    });
    return file;
}

}  // namespace mote::prep
