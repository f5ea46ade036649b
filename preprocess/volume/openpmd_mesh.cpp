// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/openpmd_mesh.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <glm/matrix.hpp>
#include <numbers>

#include "preprocess/readers/hdf5/h5_attribute.h"
#include "preprocess/readers/hdf5/h5_file.h"
#include "preprocess/readers/hdf5/h5_numbers.h"
#include "preprocess/readers/openpmd/layout.h"
#include "protocol/base/mote_check.h"
#include "protocol/scene/space/length_unit.h"

namespace mote::prep {
namespace {

// MeshRecord: a component of a mesh record of an openPMD file: its numbers and what its attributes say of the
// grid, checked. It keeps its file open; one thread at a time.

struct MeshRecord {
    /// Of a grid, in the order of the file's dimensions; of thetaMode without that of the modes.
    struct Axis {
        std::string label;     ///< "x", "y", "z" or "r"
        double spacing = 1.0;  ///< m, over 0
        double first = 0.0;    ///< m, where the first value stands
    };

    H5Numbers numbers;
    std::vector<Axis> axes;
    bool thetaMode = false;
    double sineSign = 1.0;  ///< thetaMode: of the imaginary parts
    double unitSI = 1.0;
    std::string unit;            ///< "V/m"; "" where it is not known
    std::optional<double> time;  ///< s, of the iteration
    std::string where;
    std::vector<std::string> notes = {};  ///< what was assumed

    /// Errors: as openOpenpmdMesh.
    static Result<MeshRecord> open(const std::filesystem::path& path, const MeshField& field);
};

using Dimension = std::array<double, 7>;

struct KnownUnit {
    Dimension dimension;
    const char* name;
};

/// Powers of m, kg, s, A, K, mol, cd.
constexpr std::array<KnownUnit, 6> knownUnits{{{{1, 1, -3, -1, 0, 0, 0}, "V/m"},
                                               {{0, 1, -2, -1, 0, 0, 0}, "T"},
                                               {{-3, 0, 1, 1, 0, 0, 0}, "C/m^3"},
                                               {{-2, 0, 0, 1, 0, 0, 0}, "A/m^2"},
                                               {{-3, 0, 0, 0, 0, 0, 0}, "1/m^3"},
                                               {{2, 1, -3, -1, 0, 0, 0}, "V"}}};

Error noneOf(const std::string& where, const std::string& what, const std::vector<std::string>& there) {
    return notFound(where, there.empty()
                               ? what + "; it holds none"
                               : fmt::format("{}; there {} {}", what, there.size() == 1 ? "is" : "are",
                                             fmt::join(there, ", ")));
}

Result<OpenpmdIteration> chosenIteration(const H5File& file, const OpenpmdLayout& layout,
                                         const MeshField& field) {
    const auto& all = layout.iterations;
    if (!field.iteration && all.size() == 1) return all.front();
    for (const auto& each : all) {
        if (field.iteration == each.number) return each;
    }
    std::vector<std::string> numbers;
    for (std::size_t i = 0; i < std::min<std::size_t>(all.size(), 20); ++i)
        numbers.push_back(std::to_string(all[i].number));
    return noneOf(file.name(),
                  field.iteration ? fmt::format("has no iteration {}", *field.iteration)
                                  : "has several iterations: name one, as ITERATION:RECORD",
                  numbers);
}

/// "/data/550/fields" of the meshes, where they are.
Result<std::optional<H5Object>> meshesGroup(const H5File& file, const OpenpmdIteration& iteration) {
    MOTE_ASSIGN_OR_RETURN(const auto path, textAttribute(file.root(), "meshesPath"));
    MOTE_ASSIGN_OR_RETURN(const auto group, file.require(file.root(), iteration.path));
    auto meshes = path.value_or("meshes/");
    while (meshes.starts_with('/')) meshes.erase(0, 1);
    return file.find(group, meshes);
}

/// The names of what can be drawn: records, and components of records that have some.
Result<std::vector<std::string>> fieldNames(const H5File& file, const H5Object& meshes) {
    std::vector<std::string> names;
    MOTE_ASSIGN_OR_RETURN(const auto records, file.children(meshes));
    for (const auto& record : records) {
        MOTE_ASSIGN_OR_RETURN(const auto object, file.find(meshes, record));
        if (!object) continue;
        if (!object->group) {
            names.push_back(record);
            continue;
        }
        MOTE_ASSIGN_OR_RETURN(const auto components, file.children(*object));
        if (components.empty()) names.push_back(record);  // a constant
        for (const auto& component : components) names.push_back(fmt::format("{}/{}", record, component));
    }
    return names;
}

std::string nameOf(const MeshField& field) {
    return field.component.empty() ? field.record : field.record + "/" + field.component;
}

/// The record, and the component, which may be the record itself.
struct Found {
    H5Object record, component;
    std::string name;  ///< of the component, within the meshes
};

Result<Found> findField(const H5File& file, const H5Object& meshes, const MeshField& field) {
    MOTE_ASSIGN_OR_RETURN(const auto names, fieldNames(file, meshes));
    auto wanted = nameOf(field);
    if (wanted.empty() && names.size() == 1) wanted = names.front();
    if (std::ranges::find(names, wanted) == names.end()) {
        return noneOf(meshes.where,
                      wanted.empty() ? "holds several fields: name one with --field"
                                     : fmt::format("holds no field \"{:.60}\"", wanted),
                      names);
    }
    MOTE_ASSIGN_OR_RETURN(auto record, file.require(meshes, wanted.substr(0, wanted.find('/'))));
    MOTE_ASSIGN_OR_RETURN(auto component, file.require(meshes, wanted));
    if (!component.group) return Found{std::move(record), std::move(component), wanted};
    return unsupported(component.where,
                       "is a constant, or more than numbers on a mesh: there is nothing to draw");
}

/// Reads as many finite numbers as there are axes.
Result<std::vector<double>> perAxis(const H5Object& object, const char* name, std::size_t axes,
                                    std::optional<double> missing) {
    MOTE_ASSIGN_OR_RETURN(auto values, numbersAttribute(object, name));
    if (!values && missing) return std::vector<double>(axes, *missing);
    const auto where = object.where + "@" + name;
    if (!values) return corrupt(where, "is missing: the mesh has no place");
    if (values->size() != axes) {
        return corrupt(where, fmt::format("has {} numbers where the mesh has {} axes", values->size(), axes));
    }
    for (const double value : *values) {
        if (!std::isfinite(value)) return corrupt(where, "is not finite");
    }
    return *std::move(values);
}

/// Some write a number for each dimension of the data, where in thetaMode the first is the one of the modes
/// and lies nowhere: the others are r's and z's.
Result<std::vector<double>> positionInCell(const H5Object& component, std::size_t axes, MeshRecord& record) {
    MOTE_ASSIGN_OR_RETURN(const auto values, numbersAttribute(component, "position"));
    const bool ofModes = record.thetaMode && values && values->size() == axes + 1;
    MOTE_ASSIGN_OR_RETURN(auto numbers, perAxis(component, "position", axes + (ofModes ? 1 : 0), 0.0));
    if (!ofModes) return numbers;
    if (std::ranges::count(numbers, numbers.front()) != std::ssize(numbers)) {
        record.notes.push_back(component.where +
                               "@position: has three numbers, of which the last two were taken for r and z");
    }
    numbers.erase(numbers.begin());
    return numbers;
}

Status readAxes(const Found& found, std::size_t dimensions, MeshRecord& record) {
    MOTE_ASSIGN_OR_RETURN(auto labels, textsAttribute(found.record, "axisLabels"));
    MOTE_ASSIGN_OR_RETURN(const auto order, textAttribute(found.record, "dataOrder"));
    const auto where = found.record.where + "@axisLabels";
    if (!labels) return corrupt(where, "is missing");
    if (labels->size() != dimensions) {
        return corrupt(where, fmt::format("names {} axes of a mesh of {}", labels->size(), dimensions));
    }
    MOTE_ASSIGN_OR_RETURN(const auto spacing, perAxis(found.record, "gridSpacing", dimensions, std::nullopt));
    MOTE_ASSIGN_OR_RETURN(const auto offset, perAxis(found.record, "gridGlobalOffset", dimensions, 0.0));
    MOTE_ASSIGN_OR_RETURN(const auto inCell, positionInCell(found.component, dimensions, record));
    MOTE_ASSIGN_OR_RETURN(const auto unit, numbersAttribute(found.record, "gridUnitSI"));
    for (std::size_t i = 0; i < dimensions; ++i) {
        // One for all axes; since version 2 one for each.
        const double scale = !unit || unit->empty() ? 1.0 : (*unit)[unit->size() == dimensions ? i : 0];
        MeshRecord::Axis axis{(*labels)[i], spacing[i] * scale, (offset[i] + inCell[i] * spacing[i]) * scale};
        if (!(axis.spacing > 0.0) || !std::isfinite(axis.spacing) || !std::isfinite(axis.first))
            return corrupt(found.record.where + "@gridSpacing", "is no spacing of a mesh");
        record.axes.push_back(std::move(axis));
    }
    // The first axis is the fastest one then.
    if (order && order->starts_with('F')) std::ranges::reverse(record.axes);
    return success();
}

Status checkAxes(const MeshRecord& record) {
    const std::string_view allowed = record.thetaMode ? "rz" : "xyz";
    std::string seen;
    for (const auto& axis : record.axes) {
        const bool known = axis.label.size() == 1 && allowed.find(axis.label) != std::string_view::npos;
        if (!known || seen.find(axis.label) != std::string::npos) {
            return unsupported(record.where,
                               fmt::format("has an axis \"{:.20}\"; meshes of {} are read", axis.label,
                                           record.thetaMode ? "r and z" : "x, y and z"));
        }
        seen += axis.label;
    }
    return success();
}

Status readGeometry(const Found& found, MeshRecord& record) {
    MOTE_ASSIGN_OR_RETURN(const auto geometry, textAttribute(found.record, "geometry"));
    MOTE_ASSIGN_OR_RETURN(const auto parameters, textAttribute(found.record, "geometryParameters"));
    record.thetaMode = geometry.value_or("cartesian") == "thetaMode";
    if (!record.thetaMode && geometry.value_or("cartesian") != "cartesian") {
        return unsupported(
            record.where,
            fmt::format("is of geometry \"{:.20}\"; cartesian and thetaMode are read", *geometry));
    }
    if (parameters && parameters->find("imag=-") != std::string::npos) record.sineSign = -1.0;
    const auto rank = record.numbers.extent().size();
    const std::size_t least = record.thetaMode ? 3 : 2;
    if (rank < least || rank > 3) {
        return unsupported(record.where, fmt::format("has {} dimensions", rank));
    }
    if (record.thetaMode && record.numbers.extent()[0] % 2 == 0) {
        return corrupt(record.where,
                       fmt::format("has {} parts of modes; the first mode has one, each other two",
                                   record.numbers.extent()[0]));
    }
    MOTE_RETURN_IF_ERROR(readAxes(found, record.thetaMode ? 2 : rank, record));
    return checkAxes(record);
}

Status readUnits(const Found& found, const H5Object& iteration, MeshRecord& record) {
    MOTE_ASSIGN_OR_RETURN(const auto scale, numberAttribute(found.component, "unitSI"));
    MOTE_ASSIGN_OR_RETURN(const auto dimension, numbersAttribute(found.record, "unitDimension"));
    MOTE_ASSIGN_OR_RETURN(const auto time, numberAttribute(iteration, "time"));
    MOTE_ASSIGN_OR_RETURN(const auto timeUnit, numberAttribute(iteration, "timeUnitSI"));
    record.unitSI = scale.value_or(1.0);
    if (!std::isfinite(record.unitSI)) return corrupt(record.where + "@unitSI", "is not finite");
    for (const auto& unit : knownUnits) {
        if (dimension && std::ranges::equal(*dimension, unit.dimension)) record.unit = unit.name;
    }
    if (time && std::isfinite(*time * timeUnit.value_or(1.0))) record.time = *time * timeUnit.value_or(1.0);
    return success();
}

Result<MeshRecord> MeshRecord::open(const std::filesystem::path& path, const MeshField& field) {
    MOTE_ASSIGN_OR_RETURN(const auto file, H5File::open(path));
    MOTE_ASSIGN_OR_RETURN(const auto layout, readOpenpmdLayout(file));
    MOTE_ASSIGN_OR_RETURN(const auto iteration, chosenIteration(file, layout, field));
    MOTE_ASSIGN_OR_RETURN(const auto meshes, meshesGroup(file, iteration));
    if (!meshes || !meshes->group) return notFound(file.name() + ":" + iteration.path, "holds no meshes");
    MOTE_ASSIGN_OR_RETURN(auto found, findField(file, *meshes, field));
    const auto where = found.component.where;
    // The numbers are read as long as the volume is, the attributes only now.
    MOTE_ASSIGN_OR_RETURN(auto again, file.require(*meshes, found.name));
    MOTE_ASSIGN_OR_RETURN(auto numbers, H5Numbers::open(file, std::move(again)));
    MeshRecord record{std::move(numbers), {}, false, 1.0, 1.0, "", std::nullopt, where};
    MOTE_RETURN_IF_ERROR(readGeometry(found, record));
    MOTE_ASSIGN_OR_RETURN(const auto group, file.require(file.root(), iteration.path));
    MOTE_RETURN_IF_ERROR(readUnits(found, group, record));
    return record;
}

namespace fs = std::filesystem;

constexpr std::uint64_t mostModeBytes = std::uint64_t{1} << 30;  // as doubles

constexpr double degree = std::numbers::pi / 180.0;

Error wrongField(const std::string& text) {
    return invalid("field", fmt::format("\"{:.60}\" is not [ITERATION:]RECORD[/COMPONENT][@DEGREES]", text));
}

template <class Number>
std::optional<Number> numberIn(std::string_view text) {
    Number number{};
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (code != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return number;
}

ScalarType typeOf(const H5Numbers& numbers) {
    const auto bytes = numbers.valueBytes();
    if (numbers.isFloat()) return bytes <= 4 ? ScalarType::f32 : ScalarType::f64;
    if (bytes == 1) return numbers.isSigned() ? ScalarType::i8 : ScalarType::u8;
    if (bytes == 2) return numbers.isSigned() ? ScalarType::i16 : ScalarType::u16;
    if (bytes == 4) return numbers.isSigned() ? ScalarType::i32 : ScalarType::u32;
    return ScalarType::f64;
}

/// The unit in thousands of which a cell is 1 to 1000 wide: OpenVDB takes a grid of micrometres in metres for
/// a flat one.
LengthUnit worldUnitOf(double width) {
    auto chosen = ownLengthUnits.front();
    for (const char* name : {"fm", "pm", "nm", "um", "mm", "m", "km"}) {
        const auto metres = metresOf(name).value();
        if (metres <= width * (1.0 + 1e-9)) chosen = {name, metres};
    }
    return chosen;
}

/// What all have: the record's own words.
class MeshVolume : public VolumeSource {
  public:
    std::string format() const override { return "openpmd"; }
    const VolumeShape& shape() const override { return shape_; }
    bool sequential() const override { return false; }
    std::optional<double> time() const override { return record_.time; }

  protected:
    explicit MeshVolume(MeshRecord record) : record_(std::move(record)) {
        shape_.type = typeOf(record_.numbers);
        shape_.valueUnit = record_.unit;
        shape_.notes = record_.notes;
        // Integers are floats once they have a unit.
        if (!record_.numbers.isFloat() && record_.unitSI != 1.0) shape_.valueStep = std::abs(record_.unitSI);
    }

    /// The steps of a voxel along the volume's axes and the place of the first one, m.
    Status setPlace(const glm::dmat3& steps, const glm::dvec3& origin) {
        const auto unit = worldUnitOf(std::cbrt(std::abs(glm::determinant(steps))));
        shape_.worldUnit = std::string(unit.name);
        return setPlacement(shape_, steps / unit.metres, origin / unit.metres, record_.where);
    }

    MeshRecord record_;
    VolumeShape shape_;
};

/// A cartesian mesh as it lies in the file: its fastest dimension is the volume's first, whichever axis of
/// the world that is.
class CartesianMesh final : public MeshVolume {
  public:
    static Result<std::unique_ptr<VolumeSource>> make(MeshRecord record) {
        std::unique_ptr<CartesianMesh> mesh(new CartesianMesh(std::move(record)));
        MOTE_RETURN_IF_ERROR(mesh->place());
        return std::unique_ptr<VolumeSource>(std::move(mesh));
    }

    Status read(std::uint32_t z0, std::uint32_t z1, std::span<float> values) override {
        MOTE_CHECK(z0 <= z1 && z1 <= shape_.nz && values.size() == shape_.voxelsOfSlice() * (z1 - z0));
        std::vector<hsize_t> first(record_.axes.size(), 0), count = record_.numbers.extent();
        if (count.size() == 3) {
            first[0] = z0;
            count[0] = z1 - z0;
        } else if (z0 == z1) {
            return success();
        }
        numbers_.resize(values.size());
        MOTE_RETURN_IF_ERROR(record_.numbers.read(first, count, H5T_NATIVE_DOUBLE, numbers_.data()));
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = static_cast<float>(numbers_[i] * record_.unitSI);
        return success();
    }

  private:
    using MeshVolume::MeshVolume;

    Status place() {
        const auto& extent = record_.numbers.extent();
        std::array<std::uint64_t, 3> sizes{1, 1, 1};  // the fastest first
        glm::dmat3 steps(0.0);
        glm::dvec3 origin(0.0);
        double least = record_.axes.front().spacing;
        std::array<bool, 3> used{};
        const auto dimensions = static_cast<int>(extent.size());
        for (int i = 0; i < dimensions; ++i) {
            const auto& axis = record_.axes[static_cast<std::size_t>(i)];
            const int world = axis.label[0] - 'x', own = dimensions - 1 - i;
            sizes[static_cast<std::size_t>(own)] = extent[static_cast<std::size_t>(i)];
            steps[own][world] = axis.spacing;
            origin[world] = axis.first;
            used[static_cast<std::size_t>(world)] = true;
            least = std::min(least, axis.spacing);
        }
        // A plane is one cell thick.
        const auto missing = std::ranges::find(used, false);
        if (missing != used.end()) steps[2][static_cast<int>(missing - used.begin())] = least;
        MOTE_RETURN_IF_ERROR(setDimensions(shape_, sizes[0], sizes[1], sizes[2], record_.where));
        return setPlace(steps, origin);
    }

    std::vector<double> numbers_;
};

/// F(r, theta, z) = F0 + sum over m of (Re Fm cos(m theta) + Im Fm sin(m theta)), linear in r between the
/// mesh's values, on the nodes of a cartesian grid as fine as the mesh, or of a plane that holds the axis.
class ModesVolume final : public MeshVolume {
  public:
    static Result<std::unique_ptr<VolumeSource>> make(MeshRecord record, std::optional<double> degrees) {
        std::unique_ptr<ModesVolume> volume(new ModesVolume(std::move(record), degrees));
        MOTE_RETURN_IF_ERROR(volume->place());
        return std::unique_ptr<VolumeSource>(std::move(volume));
    }

    Status read(std::uint32_t z0, std::uint32_t z1, std::span<float> values) override {
        MOTE_CHECK(z0 <= z1 && z1 <= shape_.nz && values.size() == shape_.voxelsOfSlice() * (z1 - z0));
        MOTE_RETURN_IF_ERROR(load());
        for (std::size_t i = 0; i < shape_.voxelsOfSlice(); ++i) {
            const auto terms = termsAt(i % shape_.nx, i / shape_.nx);
            for (std::uint32_t z = z0; z < z1; ++z) {
                double sum = 0.0;
                for (const auto& term : terms) sum += term.factor * modes_[term.row + z * zStep_];
                values[(z - z0) * shape_.voxelsOfSlice() + i] = static_cast<float>(sum * record_.unitSI);
            }
        }
        return success();
    }

  private:
    /// A share of a part of a mode at a radius: the place of its value at z = 0.
    struct Term {
        double factor;
        std::size_t row;
    };

    ModesVolume(MeshRecord record, std::optional<double> degrees)
        : MeshVolume(std::move(record)), degrees_(degrees) {
        rFirst_ = record_.axes[0].label == "r";
        polar_ = record_.where.ends_with("/r") || record_.where.ends_with("/t");
        const auto& extent = record_.numbers.extent();
        nr_ = extent[rFirst_ ? 1 : 2];
        nz_ = extent[rFirst_ ? 2 : 1];
        zStep_ = rFirst_ ? 1 : nr_;
        rStep_ = rFirst_ ? nz_ : 1;
    }

    const MeshRecord::Axis& r() const { return record_.axes[rFirst_ ? 0 : 1]; }
    const MeshRecord::Axis& z() const { return record_.axes[rFirst_ ? 1 : 0]; }

    Status place() {
        const auto& extent = record_.numbers.extent();
        const std::uint64_t across = nr_ > VolumeShape::maxDimension ? nr_ : 2 * nr_;
        MOTE_RETURN_IF_ERROR(setDimensions(shape_, across, degrees_ ? 1 : across, nz_, record_.where));
        // Below 2^16 each; the modes are not bounded yet.
        if (extent[0] > mostModeBytes / sizeof(double) / (nr_ * nz_)) {
            return Error{ErrorCode::resourceExhausted, record_.where, "has modes of more than 1 GiB"};
        }
        const double angle = degrees_.value_or(0.0) * degree;
        const glm::dvec3 along(std::cos(angle), std::sin(angle), 0.0), aside(-along.y, along.x, 0.0);
        const glm::dmat3 steps(along * r().spacing, aside * r().spacing, glm::dvec3(0.0, 0.0, z().spacing));
        const double edge = placeOf(0);
        glm::dvec3 origin = along * edge + (degrees_ ? glm::dvec3(0.0) : aside * edge);
        origin.z = z().first;
        return setPlace(steps, origin);
    }

    /// The place of a node across the axis, m: none lies on it, so that an angle is there.
    double placeOf(std::size_t node) const {
        return (static_cast<double>(node) - static_cast<double>(nr_) + 0.5) * r().spacing;
    }

    Status load() {
        const auto& extent = record_.numbers.extent();
        if (!modes_.empty()) return success();
        modes_.resize(extent[0] * nr_ * nz_);
        const std::vector<hsize_t> first(3, 0);
        return record_.numbers.read(first, extent, H5T_NATIVE_DOUBLE, modes_.data());
    }

    /// What is added up at a node. Nothing beyond the outermost value.
    std::vector<Term> termsAt(std::size_t i, std::size_t j) const {
        const double across = placeOf(i), aside = degrees_ ? 0.0 : placeOf(j);
        const double radius = std::hypot(across, aside);
        const double angle = degrees_ ? *degrees_ * degree + (across < 0.0 ? std::numbers::pi : 0.0)
                                      : std::atan2(aside, across);
        const double at = (radius - r().first) / r().spacing;
        std::vector<Term> terms;
        if (at > static_cast<double>(nr_ - 1) + 0.5) return terms;
        for (std::size_t part = 0; part < record_.numbers.extent()[0]; ++part) {
            const auto mode = (part + 1) / 2;
            const bool sine = part > 0 && part % 2 == 0;
            const double phase = static_cast<double>(mode) * angle;
            const double factor = sine ? record_.sineSign * std::sin(phase) : std::cos(phase);
            addAt(at, mode, factor, part * nr_ * nz_, terms);
        }
        return terms;
    }

    void addAt(double at, std::size_t mode, double factor, std::size_t base, std::vector<Term>& terms) const {
        const double clamped = std::min(at, static_cast<double>(nr_ - 1));
        const double below = std::floor(clamped), share = clamped - below;
        const auto row = [&](double index) {
            return base +
                   static_cast<std::size_t>(std::clamp(index, 0.0, static_cast<double>(nr_ - 1))) * rStep_;
        };
        // Within the first value the mesh goes on across the axis: at r' = -r the angle is the opposite one,
        // and with it the directions of r and theta.
        const double opposite = below < 0.0 && (mode % 2 == 1) != polar_ ? -1.0 : 1.0;
        terms.push_back({factor * opposite * (1.0 - share), row(below < 0.0 ? -below - 1.0 : below)});
        terms.push_back({factor * share, row(below + 1.0)});
    }

    const std::optional<double> degrees_;
    bool rFirst_ = true, polar_ = false;
    std::uint64_t nr_ = 0, nz_ = 0;
    std::size_t rStep_ = 1, zStep_ = 1;
    std::vector<double> modes_;
};

}  // namespace

Result<std::vector<std::string>> meshFields(const std::filesystem::path& path) {
    if (!H5File::looksLikeHdf5(path)) return std::vector<std::string>();
    MOTE_ASSIGN_OR_RETURN(const auto file, H5File::open(path));
    if (!looksLikeOpenpmd(file)) return std::vector<std::string>();
    MOTE_ASSIGN_OR_RETURN(const auto layout, readOpenpmdLayout(file));
    if (layout.iterations.empty()) return notFound(file.name(), "holds no iteration");
    MOTE_ASSIGN_OR_RETURN(const auto meshes, meshesGroup(file, layout.iterations.front()));
    if (!meshes || !meshes->group) {
        return notFound(file.name() + ":" + layout.iterations.front().path, "holds no meshes");
    }
    return fieldNames(file, *meshes);
}

Result<MeshField> parseMeshField(const std::string& text) {
    MeshField field;
    std::string_view rest = text;
    if (const auto colon = rest.find(':'); colon != std::string_view::npos) {
        field.iteration = numberIn<std::int64_t>(rest.substr(0, colon));
        if (!field.iteration || *field.iteration < 0) return wrongField(text);
        rest.remove_prefix(colon + 1);
    }
    if (const auto at = rest.find('@'); at != std::string_view::npos) {
        field.degrees = numberIn<double>(rest.substr(at + 1));
        if (!field.degrees || !std::isfinite(*field.degrees)) return wrongField(text);
        rest = rest.substr(0, at);
    }
    const auto slash = rest.find('/');
    field.record = rest.substr(0, slash);
    if (slash != std::string_view::npos) field.component = rest.substr(slash + 1);
    const bool parts = slash != std::string_view::npos && (field.record.empty() || field.component.empty());
    if (parts || field.component.find('/') != std::string::npos) return wrongField(text);
    return field;
}

bool beginsAsHdf5(std::string_view bytes) {
    return bytes.starts_with("\x89HDF\r\n\x1a\n");
}

Result<bool> holdsOpenpmd(const fs::path& path) {
    MOTE_ASSIGN_OR_RETURN(const auto file, H5File::open(path));
    return looksLikeOpenpmd(file);
}

Result<std::vector<std::string>> meshSteps(const fs::path& path, const std::string& field) {
    MOTE_ASSIGN_OR_RETURN(const auto parsed, parseMeshField(field));
    if (parsed.iteration) return std::vector{field};
    MOTE_ASSIGN_OR_RETURN(const auto file, H5File::open(path));
    MOTE_ASSIGN_OR_RETURN(const auto layout, readOpenpmdLayout(file));
    if (layout.iterations.size() == 1) return std::vector{field};
    std::vector<std::string> steps;
    for (const auto& iteration : layout.iterations)
        steps.push_back(fmt::format("{}:{}", iteration.number, field));
    return steps;
}

Result<std::unique_ptr<VolumeSource>> openOpenpmdMesh(const fs::path& path, const std::string& field) {
    MOTE_ASSIGN_OR_RETURN(const auto parsed, parseMeshField(field));
    MOTE_ASSIGN_OR_RETURN(auto record, MeshRecord::open(path, parsed));
    if (record.thetaMode) return ModesVolume::make(std::move(record), parsed.degrees);
    if (!parsed.degrees) return CartesianMesh::make(std::move(record));
    return invalid("field", "an angle is of meshes of thetaMode geometry alone");
}

}  // namespace mote::prep
