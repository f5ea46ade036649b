// SPDX-License-Identifier: GPL-3.0-or-later
//
// OpenpmdComponent: one component of an openPMD particle record ("position/x", "weighting"), be it a dataset
// or a constant written as the attributes `value` and `shape`. Owned by a species; one
// thread at a time, unless it says otherwise.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "preprocess/readers/hdf5/h5_column.h"
#include "preprocess/readers/hdf5/h5_file.h"
#include "protocol/base/error.h"

namespace mote::prep {

class OpenpmdComponent {
  public:
    /// Component `name` of `record` in `species`; the record itself where `name` is empty. Nothing where it
    /// is absent. Errors: corrupt, unsupported.
    static Result<std::optional<OpenpmdComponent>> open(const H5File& file, const H5Object& species,
                                                        std::string_view record, std::string_view name);

    /// Rows that it declares; nothing for a constant without `shape`, which fits any number.
    std::optional<std::uint64_t> rows() const { return rows_; }
    bool constant() const { return !column_.has_value(); }
    /// What all rows have, in SI units, of a constant.
    std::optional<double> constantValue() const {
        return constant() ? std::optional(value_ * unitSI_) : std::nullopt;
    }
    /// Whether several threads may read() at once; or readIntegers().
    bool readsAtOnce() const { return constant() || column_->readsAtOnce(); }
    bool readsIntegersAtOnce() const { return constant() || column_->readsIntegersAtOnce(); }
    /// As H5Column::keptBytes.
    std::uint64_t keptBytes(std::size_t threads) const {
        return constant() ? 0 : column_->keptBytes(threads);
    }
    const std::string& where() const { return where_; }
    /// The power of the weighting that its values carry: 0 for those of one real particle.
    double weightingPower() const { return weightingPower_; }
    /// unitDimension of the record: powers of L, M, T, I, theta, N, J; nothing where it is not given.
    const std::optional<std::vector<double>>& unitDimension() const { return unitDimension_; }

    /// Values of rows [begin, begin + values.size()) in SI units.
    Status read(std::uint64_t begin, std::span<double> values) const;
    /// The same as integers, without units.
    Status readIntegers(std::uint64_t begin, std::span<std::uint64_t> values) const;

  private:
    Status readConstant(const H5Object& object);
    Status readMeaning(const H5Object& record, const H5Object& component, bool scalesWithWeight);

    std::string where_;
    std::optional<H5Column> column_;
    double value_ = 0.0;
    std::optional<std::uint64_t> rows_;
    double unitSI_ = 1.0;
    double weightingPower_ = 0.0;
    std::optional<std::vector<double>> unitDimension_;
};

/// The reference particle that ImpactX writes beside a beam whose coordinates are relative
/// to it.
///
/// ImpactX tracks in the path length s: it writes position/{x, y} in m and position/t = c (arrival - that of
/// the reference particle) in m, momentum/{x, y} over the reference momentum and momentum/t = -(gamma -
/// gamma_ref) / (beta gamma)_ref. Its positionOffset is the reference particle's place in the laboratory,
/// whose axes are not those of the co-moving frame, and is not added.
struct ReferenceParticle {
    double gamma = 1.0;      ///< total over rest energy
    double betaGamma = 0.0;  ///< momentum over m c
    double mass = 0.0;       ///< eV/c^2
    double time = 0.0;       ///< s

    /// False where the file leaves its gamma 0, so that nothing relative to it can be told.
    bool known() const { return gamma >= 1.0; }
    double beta() const { return betaGamma / gamma; }
    /// gamma of a particle from its momentum/t.
    double gammaOf(double momentumT) const { return gamma - momentumT * betaGamma; }

    /// Reads the attributes beta_ref, gamma_ref, mass_ref, ... of a species. Nothing where it has none of
    /// them. Errors: corrupt, notFound (an attribute is missing).
    static Result<std::optional<ReferenceParticle>> open(const H5Object& species);
};

}  // namespace mote::prep
