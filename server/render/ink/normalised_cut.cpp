// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/normalised_cut.h"

#include <Spectra/SymEigsSolver.h>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/SparseCore>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr std::size_t mostDense = 64;   // nodes whose eigenvectors are found directly
constexpr std::size_t effort = 100000;  // nodes of all graphs solved for, in sum
constexpr int mostRestarts = 50;
constexpr double accuracy = 1e-4;     // of eigenvalues, which are at most 1
constexpr double leastLink = 0.02;    // mean affinity from which on nodes are linked at all
constexpr double leastDegree = 1e-9;  // what belongs to nothing is still something

using Matrix = Eigen::MatrixXd;

/// Some nodes of a graph as one of its own.
struct Part {
    struct Neighbour {
        std::uint32_t node;
        double affinity, length;
    };

    std::vector<std::uint32_t> nodes;                // numbers in the whole
    std::vector<std::vector<Neighbour>> neighbours;  // numbers in this
    std::vector<double> degree;                      // affinity to all nodes of this, the node itself too
};

struct Stopped {};

/// A matrix as the solver asks for it; throws Stopped.
class StoppableProduct {
  public:
    using Scalar = double;

    StoppableProduct(const Eigen::SparseMatrix<double>& matrix, const std::stop_token& stop)
        : matrix_(matrix), stop_(stop) {}
    Eigen::Index rows() const { return matrix_.rows(); }
    Eigen::Index cols() const { return matrix_.cols(); }
    void perform_op(const double* in, double* out) const {
        if (isStopped(stop_)) throw Stopped();
        Eigen::Map<Eigen::VectorXd>(out, rows()).noalias() =
            matrix_ * Eigen::Map<const Eigen::VectorXd>(in, cols());
    }

  private:
    const Eigen::SparseMatrix<double>& matrix_;
    const std::stop_token& stop_;
};

Eigen::SparseMatrix<double> normalised(const Part& part, const Eigen::VectorXd& scale) {
    std::vector<Eigen::Triplet<double>> entries;
    const auto size = static_cast<Eigen::Index>(part.nodes.size());
    for (Eigen::Index i = 0; i < size; ++i) {
        double rest = part.degree[static_cast<std::size_t>(i)];
        for (const auto& other : part.neighbours[static_cast<std::size_t>(i)]) {
            const auto k = static_cast<Eigen::Index>(other.node);
            entries.emplace_back(i, k, other.affinity * scale[i] * scale[k]);
            rest -= other.affinity;
        }
        entries.emplace_back(i, i, rest * scale[i] * scale[i]);
    }
    Eigen::SparseMatrix<double> matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

/// The first eigenvectors of D^-1/2 W D^-1/2, but for the greatest's, each by the root of the degree.
Matrix eigenvectors(const Part& part, std::size_t count, const std::stop_token& stop) {
    const auto size = static_cast<Eigen::Index>(part.nodes.size());
    Eigen::VectorXd scale(size);
    for (Eigen::Index i = 0; i < size; ++i)
        scale[i] = 1.0 / std::sqrt(part.degree[static_cast<std::size_t>(i)]);
    const auto matrix = normalised(part, scale);
    const auto wanted = std::min(static_cast<Eigen::Index>(count) + 1, size);
    Matrix found;
    if (part.nodes.size() <= mostDense) {
        const Eigen::SelfAdjointEigenSolver<Matrix> solver{Matrix(matrix)};
        found = solver.eigenvectors().rightCols(wanted).rowwise().reverse();
    } else {
        StoppableProduct product(matrix, stop);
        Spectra::SymEigsSolver<StoppableProduct> solver(product, wanted, 4 * wanted);
        solver.init();
        solver.compute(Spectra::SortRule::LargestAlge, mostRestarts, accuracy);
        found = solver.eigenvectors();
    }
    if (found.cols() < 2) return Matrix(size, 0);
    return scale.asDiagonal() * found.rightCols(found.cols() - 1);
}

struct Cut {
    double cost = HUGE_VAL;
    std::vector<bool> side;
};

/// Tries all cuts of nodes in an order.
class Sweep {
  public:
    Sweep(const Part& part, const CutOptions& options)
        : part_(part),
          options_(options),
          whole_(std::accumulate(part.degree.begin(), part.degree.end(), 0.0)) {}

    void along(const Eigen::VectorXd& values) {
        std::vector<std::uint32_t> order(part_.nodes.size());
        std::iota(order.begin(), order.end(), 0U);
        std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
            return values[a] != values[b] ? values[a] < values[b] : a < b;
        });
        std::vector<bool> side(order.size());
        double across = 0.0, length = 0.0, degree = 0.0;
        std::size_t bestCount = 0;
        for (std::size_t i = 0; i + 1 < order.size(); ++i) {
            side[order[i]] = true;
            degree += part_.degree[order[i]];
            for (const auto& other : part_.neighbours[order[i]]) {
                across += side[other.node] ? -other.affinity : other.affinity;
                length += side[other.node] ? -other.length : other.length;
            }
            const double cost = across / degree + across / std::max(whole_ - degree, leastDegree);
            if (!(across < options_.meanAffinity * length) || !(cost < std::min(best_.cost, options_.cost)))
                continue;
            best_.cost = cost;
            bestCount = i + 1;
        }
        if (bestCount == 0) return;
        best_.side.assign(order.size(), false);
        for (std::size_t i = 0; i < bestCount; ++i) best_.side[order[i]] = true;
    }
    const Cut& best() const { return best_; }

  private:
    const Part& part_;
    const CutOptions& options_;
    const double whole_;
    Cut best_;
};

class Cutter {
  public:
    Cutter(const RegionGraph& graph, const CutOptions& options, const std::stop_token& stop)
        : options_(options),
          stop_(stop),
          neighbours_(graph.inside.size()),
          inside_(graph.inside),
          group_(graph.inside.size()) {
        for (const auto& link : graph.links) {
            neighbours_[link.a].push_back({link.b, link.affinity, link.length});
            neighbours_[link.b].push_back({link.a, link.affinity, link.length});
        }
        connect(allNodes());
    }
    std::vector<std::uint32_t> make() {
        while (!open_.empty() && !isStopped(stop_)) {
            const auto nodes = std::move(open_.back());
            open_.pop_back();
            const auto part = partOf(nodes);
            if (!hasBoundary(part)) continue;
            if (nodes.size() > effort_) {
                single(nodes);
                continue;
            }
            effort_ -= nodes.size();
            cut(part);
        }
        return group_;
    }

  private:
    std::vector<std::uint32_t> allNodes() const {
        std::vector<std::uint32_t> nodes(group_.size());
        std::iota(nodes.begin(), nodes.end(), 0U);
        return nodes;
    }
    void single(const std::vector<std::uint32_t>& nodes) {
        for (const auto node : nodes) group_[node] = count_++;
    }
    /// In two, if any cut may stand.
    void cut(const Part& part) {
        Sweep sweep(part, options_);
        const Matrix vectors = eigenvectors(part, options_.vectors, stop_);
        if (vectors.cols() == 0) return single(part.nodes);
        for (Eigen::Index i = 0; i < vectors.cols(); ++i) sweep.along(vectors.col(i));
        const auto& side = sweep.best().side;
        if (side.empty()) return;
        std::array<std::vector<std::uint32_t>, 2> sides;
        for (std::size_t i = 0; i < side.size(); ++i) sides[side[i] ? 1 : 0].push_back(part.nodes[i]);
        for (const auto& nodes : sides) connect(nodes);
    }
    /// Makes of nodes as many groups as there are connected ones. What is hardly linked would be cut first,
    /// and eigenvectors are the harder to find the more of that there is.
    void connect(const std::vector<std::uint32_t>& nodes) {
        constexpr std::uint32_t none = UINT32_MAX;
        for (const auto node : nodes) group_[node] = none;
        // What is in no group is among these nodes: all others are in one.
        for (const auto seed : nodes) {
            if (group_[seed] != none) continue;
            std::vector<std::uint32_t> front{seed};
            group_[seed] = count_;
            for (std::size_t next = 0; next < front.size(); ++next) {
                for (const auto& other : neighbours_[front[next]]) {
                    if (group_[other.node] != none || other.affinity < leastLink * other.length) continue;
                    group_[other.node] = count_;
                    front.push_back(other.node);
                }
            }
            std::sort(front.begin(), front.end());
            open_.push_back(std::move(front));
            ++count_;
        }
    }
    Part partOf(const std::vector<std::uint32_t>& nodes) {
        Part part{nodes, std::vector<std::vector<Part::Neighbour>>(nodes.size()), {}};
        const auto group = group_[nodes.front()];
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            double degree = inside_[nodes[i]] + leastDegree;
            for (const auto& other : neighbours_[nodes[i]]) {
                if (group_[other.node] != group) continue;
                const auto place = std::lower_bound(nodes.begin(), nodes.end(), other.node);
                part.neighbours[i].push_back(
                    {static_cast<std::uint32_t>(place - nodes.begin()), other.affinity, other.length});
                degree += other.affinity;
            }
            part.degree.push_back(degree);
        }
        return part;
    }
    /// Whether any two nodes have so little affinity that a cut between some may stand.
    bool hasBoundary(const Part& part) const {
        for (const auto& neighbours : part.neighbours) {
            for (const auto& other : neighbours) {
                if (other.affinity < options_.meanAffinity * other.length) return true;
            }
        }
        return false;
    }

    const CutOptions& options_;
    const std::stop_token& stop_;
    std::vector<std::vector<Part::Neighbour>> neighbours_;
    const std::vector<double>& inside_;
    std::vector<std::uint32_t> group_;
    std::vector<std::vector<std::uint32_t>> open_;
    std::size_t effort_ = effort;
    std::uint32_t count_ = 0;
};

/// How matrices are parted into blocks is told by a processor's caches otherwise, and with it how sums are
/// rounded.
void fixBlocks() {
    static const bool fixed = [] {
        Eigen::setCpuCacheSizes(32 << 10, 512 << 10, 2 << 20);
        return true;
    }();
    static_cast<void>(fixed);
}

}  // namespace

std::vector<std::uint32_t> normalisedCuts(const RegionGraph& graph, const CutOptions& options,
                                          const std::stop_token& stop) {
    fixBlocks();
    try {
        return Cutter(graph, options, stop).make();
    } catch (const Stopped&) {
        return std::vector<std::uint32_t>(graph.inside.size());
    }
}

}  // namespace mote::render
