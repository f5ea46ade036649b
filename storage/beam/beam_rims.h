// SPDX-License-Identifier: GPL-3.0-or-later
//
// BeamRims: percentiles by action (BeamPercentiles) of particles of one weight in the very pass that takes
// their moments. By which ellipse actions go is known only when that pass has ended; a sample tells ellipses
// that are nearly these. About each cut lies a rim, between two of the sample's ellipses: what lies in it is
// kept, and what lies outside is summed up. When the moments are known, actions within the rim are told
// exactly, and so is whether the cut's ellipse lies in its rim everywhere. If it does, the same particles are
// found inside as BeamPercentiles finds; else nothing is said.
//
// Immutable but for a count of what is kept; add() may be called by several threads at once. Coordinates are
// m and eV/c.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "storage/beam/beam_statistics.h"

namespace mote::storage {

class BeamRims {
  public:
    static constexpr std::size_t planes = BeamPercentiles::planes, cuts = BeamPercentiles::cuts;
    using Emittances = std::array<double, cuts>;  ///< as BeamPercentiles::emittances()

    struct Outside {  ///< of a rim: particles, and sums of deviations from the sample's means
        std::uint64_t count = 0;
        double q = 0.0, p = 0.0, qq = 0.0, qp = 0.0, pp = 0.0;
    };
    struct Place {
        double q = 0.0, p = 0.0;
    };
    /// In chunks, so that they stay where they are.
    class Places {
      public:
        void add(Place place) {
            if (size_ % chunk == 0) chunks_.emplace_back().reserve(chunk);
            chunks_.back().push_back(place);
            ++size_;
        }
        std::size_t size() const { return size_; }
        std::span<const std::vector<Place>> chunks() const { return chunks_; }

      private:
        static constexpr std::size_t chunk = 4096;
        std::vector<std::vector<Place>> chunks_;
        std::size_t size_ = 0;
    };
    /// What a block's rows leave; one thread at a time.
    struct Gathered {
        std::array<Outside, cuts> outside{};  ///< by plane, then percent
        std::array<Places, cuts> within;      ///< the rim
    };

    /// Of so many particles. Uses all threads of the calling arena.
    BeamRims(std::span<const BeamSample> sample, std::uint64_t particles);

    /// Whether the sample told anything. If not, nothing else may be called.
    bool known() const { return known_; }
    /// `whole`: all of the rows take part, which BeamMoments::add() tells.
    void add(const BeamRows& rows, bool whole, Gathered& gathered);
    /// By total() of all moments and what all blocks left, in their order. Nothing if the sample was wrong.
    /// Uses all threads of the calling arena.
    std::optional<Emittances> emittances(const BeamMoments::Sums& total,
                                         std::span<const Gathered> blocks) const;

  private:
    static constexpr auto percents = BeamPercentiles::percents;
    struct Rim {  ///< actions by the sample's ellipse
        double lowest = 0.0, end = 0.0;
    };
    class Piece;
    class Within;
    void findRims(std::size_t plane, std::vector<double> actions);
    void addPlane(std::size_t plane, std::span<const double> q, const double* p, Gathered& gathered) const;
    std::optional<double> emittance(const BeamMoments::Sums& total, std::size_t cut,
                                    std::span<const Gathered> blocks) const;
    bool isIn(const PlaneFrame& exact, double action, std::size_t cut) const;

    std::array<PlaneFrame, planes> frames_{};
    std::array<Rim, cuts> rims_{};
    bool known_ = false;
    std::uint64_t mostWithin_;
    std::atomic<std::uint64_t> within_{0};
};

}  // namespace mote::storage
