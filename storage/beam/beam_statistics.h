// SPDX-License-Identifier: GPL-3.0-or-later
//
// The statistics of a set of particles: names, units and definitions in docs/NUMBERS.md, those of
// openPMD-beamphysics if it has them. Particles come in blocks, pass after pass: a BeamMoments takes all
// blocks once; a BeamPercentiles, made from it, says whether it needs (mostly two, seldom more) further
// passes over the same blocks. Coordinates are m, s and eV/c. Each thread or process may have an accumulator
// of its own; merged in any order they give the same bits, as long as the particles are cut into the same
// blocks, each with its own number. Values; one thread at a time each.
//
// Sums of small pieces are about a point within a few sigma of the piece's mean, pieces are joined by the
// formulas of Chan, Golub and LeVeque 1983 (doi 10.1080/00031305.1983.10483115), to the fourth order by
// shifting moments: no sum cancels, whatever the distance of the beam from the origin.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "protocol/quantity/statistic.h"

namespace mote::storage {

/// A block of particles.
struct BeamRows {
    static constexpr std::size_t coordinates = 7;  ///< x y z t px py pz

    std::array<std::span<const double>, coordinates> coordinate;  ///< as long as each other; empty: not known
    std::span<const double> weight;                               ///< empty: 1 each
    std::uint64_t block = 0;  ///< its number; the rows of one may come in parts, one behind another
    std::size_t size = 0;
};

/// First pass: all moments. A particle takes part if all its known coordinates are finite and its weight
/// is finite and not negative; in what needs slopes (xp, yp) if these are finite too.
class BeamMoments {
  public:
    /// Of system a: x px y py z pz t energy p; of system b: x xp y yp p.
    static constexpr std::size_t sizeA = 9, sizeB = 5;
    template <std::size_t N>
    struct Second {
        std::uint64_t count = 0;
        double weight = 0.0;
        std::array<double, N> mean{}, least{}, greatest{};  ///< weighted mean; extremes of all that take part
        std::array<double, N*(N + 1) / 2> sum{};  ///< weight x deviation x deviation, row by row of b >= a
    };
    /// Sums of weight x q^i p^j about the means, i + j = 3 and 4, of a coordinate and its momentum.
    struct Plane {
        std::array<double, 4> third{};   ///< q^3, q^2 p, q p^2, p^3
        std::array<double, 5> fourth{};  ///< q^4, q^3 p, q^2 p^2, q p^3, p^4
    };
    struct Sums {
        std::uint64_t block = 0;
        std::uint64_t particles = 0;  ///< that were given
        std::uint32_t known = 0;      ///< bit c: coordinate c
        double greatestWeight = 0.0;
        bool oneWeight = true;  ///< false: weights may differ
        Second<sizeA> a;
        Second<sizeB> b;
        std::array<Plane, 3> planes{};  ///< x, y, z with their momenta
    };

    /// `mass`: eV/c^2; 0: not known, and energy is left out.
    explicit BeamMoments(double mass = 0.0) : mass_(mass) {}

    /// Returns how many of the rows take part.
    std::uint64_t add(const BeamRows& rows);
    /// What another thread or process has, of the same mass.
    void merge(std::span<const Sums> blocks) { blocks_.insert(blocks_.end(), blocks.begin(), blocks.end()); }
    std::span<const Sums> blocks() const { return blocks_; }
    double mass() const { return mass_; }

    /// Of all blocks, in the order of their numbers.
    Sums total() const;

  private:
    double mass_;
    std::vector<Sums> blocks_;
};

/// Some of the particles: of all of them one in strideOf(), in an order in which neighbours are alike, so
/// that cuts of all lie near theirs. May be held in several parts, one behind another.
class BeamSample {
  public:
    /// Of so many particles: 32 or more, so that half a million at most are taken.
    static std::uint64_t strideOf(std::uint64_t particles);

    void reserve(std::size_t rows) { room_ = rows; }
    void add(const BeamRows& rows);
    std::size_t size() const { return size_; }
    BeamRows rows() const;

  private:
    std::array<std::vector<double>, BeamRows::coordinates> coordinate_;
    std::vector<double> weight_;
    std::size_t size_ = 0, room_ = 0;
};

/// An ellipse in the plane of a coordinate and its momentum: action = a q^2 + b (p - k q)^2, about q and p.
struct PlaneFrame {
    double q = 0.0, p = 0.0, a = 0.0, b = 0.0, k = 0.0;
    bool defined = false;  ///< both are known, and there is an area
};

/// Further passes: the rms emittances of those with the smallest single-particle action, in x, y and z, that
/// hold 90, 95 and 99% of the weight. The cuts are exact: bins of actions are narrowed until few particles
/// are near a cut, and these are sorted. Weights are compared as whole 2^31sts of the greatest.
///
/// Where a sample tells windows, one pass is enough. What it says is checked by what lies below each window
/// and in it; where a cut lies elsewhere, passes begin anew without it.
class BeamPercentiles {
  public:
    static constexpr std::array<std::uint32_t, 3> percents{90, 95, 99};
    static constexpr std::size_t planes = 3, cuts = planes * percents.size();

    struct Inside {  ///< weight, and weight x deviation x deviation
        double weight = 0.0, qq = 0.0, qp = 0.0, pp = 0.0;
    };
    struct BlockSums {
        std::uint64_t block = 0;
        std::array<Inside, cuts> inside{};         ///< by plane, then percent: surely below the cut
        std::array<std::uint64_t, cuts> shares{};  ///< of their weight; if a sample told the windows
        std::uint64_t allShares = 0;               ///< likewise, of all
    };
    struct NearCut {  ///< the particles of one block and one action
        double action = 0.0;
        std::uint64_t block = 0;
        std::uint64_t cut = 0;
        std::uint64_t share = 0;
        Inside of;
    };
    struct Bin {
        std::uint64_t share = 0, count = 0;  ///< of weight; of particles
    };
    /// What a thread or process gathers in one pass. All of it is trivially copyable values.
    struct Gathered {
        std::vector<Bin> bins;        ///< of all that take part in the pass: they add up
        std::vector<BlockSums> sums;  ///< one after another's
        std::vector<NearCut> near;    ///< one after another's
        bool crowded = false;         ///< so many are near cuts that they were let go

        void merge(const Gathered& other);
    };

    /// Of total() of all moments. `sample`: of the same particles; none, or too few: windows are found by a
    /// pass over all.
    explicit BeamPercentiles(const BeamMoments::Sums& total, std::span<const BeamSample> sample = {});

    /// Whether another pass over all blocks is needed.
    bool needsPass() const { return state_ != State::done; }
    void add(const BeamRows& rows, Gathered& gathered) const;
    /// Ends a pass that has seen all blocks.
    void finishPass(Gathered gathered);
    /// Ends all passes: the emittances were found otherwise.
    void finish(const std::array<double, cuts>& emittances);

    /// To be divided by the mass: m eV/c, by plane, then percent; NaN: not defined.
    const std::array<double, cuts>& emittances() const { return emittances_; }

  private:
    enum class State { sampling, narrowing, gathering, done };
    struct Window {                ///< of the bits of actions, in which a cut lies
        std::uint64_t first = 0;   ///< where bins begin; what is less lies in the first
        int shift = 0;             ///< a bin is 2^shift wide
        std::uint64_t lowest = 0;  ///< of the window
        std::uint64_t end = 0;     ///< of the window
        std::uint64_t below = 0;   ///< share of those below the window
        std::size_t bins = 0;      ///< the cut whose bins count this window too
    };
    struct Piece;
    bool counting() const { return state_ == State::sampling || state_ == State::narrowing; }
    void openWindows();
    void askSample(std::span<const BeamSample> sample);
    void count(const Piece& piece, std::size_t plane, Gathered& gathered) const;
    void gather(const Piece& piece, std::size_t plane, Gathered& gathered, BlockSums& sums) const;
    std::span<const Bin> binsOf(const Window& window, const std::vector<Bin>& bins);
    void narrow(const std::vector<Bin>& bins);
    void narrowBySample(const std::vector<Bin>& bins);
    bool sampleWasRight(const Gathered& gathered);
    void finish(Gathered& gathered);

    double shareOfWeight_ = 0.0;
    double margin_ = 0.0;    // of the weight, on both sides of a cut, where a sample tells windows
    bool bySample_ = false;  // windows are told by a sample
    std::uint64_t allShares_ = 0;
    std::array<PlaneFrame, planes> frames_{};
    std::array<Window, cuts> windows_{};
    std::array<double, cuts> emittances_{};
    State state_ = State::done;
};

/// What is known of the particles beside their coordinates.
struct BeamFacts {
    double mass = 0.0;          ///< eV/c^2; 0: not known
    std::string weightUnit;     ///< as in a manifest: "1" real particles, "C", "" not known (no charge then)
    std::uint64_t lost = 0;     ///< particles that the source marks as lost
    double meanMomentum = 0.0;  ///< eV/c, to which delta is relative; 0: the mean of these particles
    double particleCharge = 0.0;  ///< C, of one real particle; 0: not known, an elementary charge is taken
    bool neutral = false;         ///< they have no charge
};

/// By statistics(); NaN if a number is not defined (no particle, no weight, a coordinate that is not
/// known).
std::vector<double> beamValues(const BeamMoments::Sums& total, const BeamPercentiles& percentiles,
                               const BeamFacts& facts);

}  // namespace mote::storage
