// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/particle_reader.h"
#include "preprocess/readers/series_source.h"
#include "preprocess/readers/text/byte_source.h"
#include "preprocess/readers/text/number.h"

namespace mote::prep {
namespace {

// The file: two marks, the number of particles (int32), the beam's current (mA) and frequency (MHz) as
// doubles, a byte; for each particle six doubles; the rest mass (MeV). Little-endian.
constexpr std::uint64_t headerBytes = 23, rowBytes = 6 * sizeof(double), tailBytes = sizeof(double);
constexpr std::size_t countAt = 2, currentAt = 6, frequencyAt = 14;
constexpr std::size_t rowsPerBlock = 8192;
constexpr std::string_view dstMark = "\x7d\x64";
constexpr double centimetre = 1e-2, milliampere = 1e-3, megahertz = 1e6, megaelectronvolt = 1e6;

/// A particle as the file has it, and what it becomes.
struct DstParticle {
    double x = 0, xp = 0, y = 0, yp = 0, phase = 0, energy = 0;  // cm, 1, cm, 1, rad, MeV

    explicit DstParticle(const char* from) {
        double* const values[] = {&x, &xp, &y, &yp, &phase, &energy};
        for (double* value : values) {
            *value = loadNumber<double>(from, false);
            from += sizeof(double);
        }
    }
    /// Of the whole momentum, in eV/c. Not a number where the energy is negative.
    double pz(double mass) const {
        const double kinetic = energy * megaelectronvolt;
        return std::sqrt(kinetic * (kinetic + 2.0 * mass) / (1.0 + xp * xp + yp * yp));
    }
    double velocity(double mass) const {
        return speedOfLight * pz(mass) / (energy * megaelectronvolt + mass);
    }
};

class DstFile {
  public:
    /// `mass` in eV/c^2 goes before the file's, where it is not 0.
    static Result<DstFile> open(const std::filesystem::path& path, double mass);

    const std::string& name() const { return name_; }
    std::uint64_t rows() const { return rows_; }
    double mass() const { return mass_; }
    double weight() const { return weight_; }  ///< C, of each particle; 0: the file has no current
    /// As SeriesSource::readRows.
    Status read(const std::vector<Column>& wanted, ParticleChunk& chunk) const;

  private:
    Status readHeader(ByteSource& source);
    double value(Column column, const DstParticle& particle) const;

    std::filesystem::path path_;
    std::string name_;
    std::uint64_t rows_ = 0;
    double mass_ = 0.0, weight_ = 0.0, angularFrequency_ = 0.0;
};

bool positive(double value) {
    return value > 0.0 && std::isfinite(value);
}

Result<DstFile> DstFile::open(const std::filesystem::path& path, double mass) {
    MOTE_ASSIGN_OR_RETURN(const auto source, ByteSource::open(path));
    DstFile file;
    file.path_ = path;
    file.name_ = source->name();
    file.mass_ = mass;
    if (source->compressed()) {
        return unsupported(file.name_, "is a gzipped file; unpack it first (gunzip)");
    }
    MOTE_RETURN_IF_ERROR(file.readHeader(*source));
    return file;
}

Status DstFile::readHeader(ByteSource& source) {
    std::array<char, headerBytes> header{};
    MOTE_ASSIGN_OR_RETURN(const auto got, source.read(header));
    if (got < header.size() || !std::string_view(header.data(), got).starts_with(dstMark)) {
        return corrupt(name_, "is not the beginning of a TraceWin distribution (.dst)");
    }
    const auto declared = loadNumber<std::int32_t>(header.data() + countAt, false);
    const double current = loadNumber<double>(header.data() + currentAt, false) * milliampere;
    const double frequency = loadNumber<double>(header.data() + frequencyAt, false) * megahertz;
    if (declared < 0) return corrupt(name_, "declares " + std::to_string(declared) + " particles");
    rows_ = static_cast<std::uint64_t>(declared);
    const std::uint64_t bytes = headerBytes + rows_ * rowBytes + tailBytes;
    if (bytes != source.fileBytes()) {
        return corrupt(name_, "declares " + std::to_string(rows_) + " particles, which take " +
                                  std::to_string(bytes) + " bytes, and has " +
                                  std::to_string(source.fileBytes()));
    }
    if (!positive(frequency)) return corrupt(name_, "has no frequency, in bytes 14 to 21");
    angularFrequency_ = radiansPerTurn * frequency;
    const double charge = std::abs(current) / frequency;
    if (positive(charge) && rows_ > 0) weight_ = charge / static_cast<double>(rows_);
    std::array<char, tailBytes> tail{};
    MOTE_RETURN_IF_ERROR(source.seek(bytes - tailBytes));
    MOTE_ASSIGN_OR_RETURN(const auto last, source.read(tail));
    if (last != tail.size()) return corrupt(name_, "has changed since it was opened");
    const double ownMass = loadNumber<double>(tail.data(), false) * megaelectronvolt;
    if (mass_ <= 0.0) mass_ = ownMass;
    return positive(mass_) ? success() : Status(corrupt(name_, "has no rest mass in its last eight bytes"));
}

double DstFile::value(Column column, const DstParticle& particle) const {
    switch (column) {
        case Column::x:
            return particle.x * centimetre;
        case Column::y:
            return particle.y * centimetre;
        case Column::z:
            // A particle of a greater phase passes later: it lies behind.
            return -particle.phase / angularFrequency_ * particle.velocity(mass_);
        case Column::t:
            return particle.phase / angularFrequency_;
        case Column::px:
            return particle.xp * particle.pz(mass_);
        case Column::py:
            return particle.yp * particle.pz(mass_);
        case Column::pz:
            return particle.pz(mass_);
        case Column::weight:
            return weight_ > 0.0 ? weight_ : 1.0;
        case Column::id:
            break;
    }
    return 0.0;
}

Status DstFile::read(const std::vector<Column>& wanted, ParticleChunk& chunk) const {
    MOTE_ASSIGN_OR_RETURN(const auto source, ByteSource::open(path_));
    MOTE_RETURN_IF_ERROR(source->seek(headerBytes + chunk.begin * rowBytes));
    std::vector<char> block;
    for (std::size_t done = 0; done < chunk.size;) {
        const std::size_t rows = std::min(rowsPerBlock, chunk.size - done);
        block.resize(rows * rowBytes);
        MOTE_ASSIGN_OR_RETURN(const auto got, source->read(block));
        if (got != block.size()) return corrupt(name_, "has changed since it was opened");
        for (std::size_t i = 0; i < rows; ++i) {
            const DstParticle particle(block.data() + i * rowBytes);
            for (const Column column : wanted) {
                if (column != Column::id) chunk[column][done + i] = value(column, particle);
            }
        }
        done += rows;
    }
    return success();
}

class DstSource : public SeriesSource {
  public:
    DstSource(double mass, Progress& progress) : SeriesSource("tracewin", progress), wantedMass_(mass) {}

    double mass() const override { return files_.front().mass(); }
    std::string weightUnit() const override { return has(Column::weight) ? "C" : ""; }

  protected:
    Status addFile(const std::filesystem::path& path) override {
        MOTE_ASSIGN_OR_RETURN(auto file, DstFile::open(path, wantedMass_));
        if (!files_.empty() && file.mass() != files_.front().mass())
            return invalid(file.name(), "has particles of another mass than the first file");
        steps_.push_back(stepOf(path, file.rows()));
        files_.push_back(std::move(file));
        return success();
    }
    bool hasEverywhere(Column column) const override {
        if (column == Column::id) return false;
        return column != Column::weight || std::all_of(files_.begin(), files_.end(), [](const DstFile& file) {
                   return file.weight() > 0.0 || file.rows() == 0;
               });
    }
    Status readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) override {
        return files_[step].read(wanted, chunk);
    }

  private:
    double wantedMass_;
    std::vector<DstFile> files_;
};

}  // namespace

extern const ParticleReader dstReader;
constinit const ParticleReader dstReader{
    "tracewin", "TraceWin's dstMark in its first bytes", ParticleReader::Kind::bytes,
    [](const AskedFile& file) -> Result<bool> { return file.begin.starts_with(dstMark); },
    [](const AskedRun& run, Progress& progress) {
        return openSeries(std::make_unique<DstSource>(run.mass, progress), inOrder(run.files));
    }};

}  // namespace mote::prep
