// SPDX-License-Identifier: GPL-3.0-or-later
//
// A drawing of a mesh in pen and ink: what its stages cost, how much of its lines is what is seen, by a dense
// trial, how far its tones are from what is to be drawn, and how it flickers as the camera turns.
//   bench-ink NAME.mote VIEW.json [--lines] [--tones] [--times N] [--film DEGREES FRAMES [--pictures FOLDER]]
//     [--quick]
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <glm/geometric.hpp>
#include <iterator>
#include <map>
#include <mutex>
#include <numbers>
#include <string>
#include <vector>

#include "protocol/scene/camera.h"
#include "server/render/ink/complexity.h"
#include "server/render/ink/drawing.h"
#include "server/render/ink/tone_grid.h"
#include "server/render/layers/ink/line_view.h"
#include "server/render/layers/ink/mesh_lines.h"
#include "server/render/layers/ink/mesh_modalities.h"
#include "server/render/plan/stroke_fragments.h"
#include "storage/manifest.h"
#include "storage/mesh/mesh_file.h"
#include "tests/bench/ink/film.h"
#include "tests/bench/ink/line_trial.h"
#include "tests/support/view_text.h"

namespace mote::bench {
namespace {

using namespace render;
using Clock = std::chrono::steady_clock;

constexpr double sampling = 0.35;       // as at rest
constexpr double quickScale = 1.0 / 3;  // of the picture's sides, likewise
constexpr double tried = 0.1;           // pixels between places of the trial
constexpr double complexFrom = 0.3;     // what lines would cover

template <class T>
T valueOrExit(Result<T> result) {
    if (result.ok()) return *std::move(result);
    fmt::print(stderr, "bench-ink: {}\n", result.error().toString());
    std::exit(1);
}

MeshSurface read(const std::filesystem::path& dataset) {
    const auto manifest = valueOrExit(storage::readManifest(dataset));
    auto mesh = valueOrExit(storage::readMesh(dataset, manifest));
    Bounds bounds{};
    for (int i = 0; i < 3; ++i) {
        bounds.min[i] = manifest.mesh().bounds_min(i);
        bounds.max[i] = manifest.mesh().bounds_max(i);
    }
    return {std::move(mesh), bounds};
}

View readView(const std::string& file) {
    std::ifstream in(file);
    const std::string text((std::istreambuf_iterator<char>(in)), {});
    return test::viewOf(text);
}

class Watch {
  public:
    void lap(const char* stage) {
        const auto now = Clock::now();
        fmt::print("{:12} {:9.1f} ms\n", stage,
                   std::chrono::duration<double, std::milli>(now - last_).count());
        last_ = Clock::now();
    }

  private:
    Clock::time_point last_ = Clock::now();
};

struct Made {
    InkScene scene;
    std::vector<EdgeLine> edges, pieces;
    Drawing drawing;
};

InkCamera inkCamera(const FramePlan& plan, const Layer& layer) {
    return {.toEye = plan.camera.worldToEye() * layer.transform,
            .perspective = plan.camera.perspective(),
            .pixels = plan.height / (2.0 * plan.camera.halfHeight()),
            .size = {plan.width, plan.height}};
}

Made draw(const MeshSurface& surface, const Layer& layer, const FramePlan& plan) {
    const auto style = inkStyleOf(*layer.ink(), layer.inkIsDark);
    const auto begun = Clock::now();
    Watch watch;
    Made made;
    auto seen = modalitiesOf(surface, layer.transform, style, plan, {});
    made.scene.modalities = std::move(seen.modalities);
    made.scene.camera = inkCamera(plan, layer);
    watch.lap("modalities");
    const LineView view(plan, layer.transform);
    made.edges = linesOf(surface, view, style.silhouettes.crease, {});
    watch.lap("lines");
    if (plan.exact) {
        made.pieces =
            visible(surface, view, made.edges,
                    {.sampling = sampling, .likely = &seen.triangle, .farthest = &seen.farthest}, {});
        watch.lap("visible");
        made.scene.lines = chained(surface, view, made.pieces, made.scene.modalities.extent, {});
        watch.lap("chained");
    } else {
        made.scene.quick = true;
        made.scene.lines = quickLines(surface, view, made.edges, made.scene.modalities, {});
        watch.lap("quick lines");
    }
    made.drawing = drawInk(made.scene, style, plan.exact ? 1.0 : quickScale, {});
    watch.lap("drawing");
    const auto fragments = strokeFragments(made.drawing.strokes, plan.width, plan.height, 0.0);
    watch.lap("fragments");
    std::size_t count = 0;
    for (const auto& part : fragments) count += part.size();
    fmt::print(
        "total        {:9.1f} ms; {} edges that are lines, {} pieces, {} chains; {} strokes, {} points, {} "
        "fragments\n",
        std::chrono::duration<double, std::milli>(Clock::now() - begun).count(), made.edges.size(),
        made.pieces.size(), made.scene.lines.size(), made.drawing.strokes.lines.size(),
        made.drawing.strokes.points.size(), count);
    return made;
}

/// Lengths on the screen.
struct Agreement {
    double length = 0.0, missed = 0.0, hidden = 0.0;
};

void tryLines(const MeshSurface& surface, const Made& made, const FramePlan& plan) {
    const auto& mesh = surface.mesh();
    const LineTrial trial(mesh, plan.camera, plan.width, plan.height);
    using EdgeKey = std::pair<std::array<std::uint32_t, 2>, std::array<std::uint32_t, 2>>;
    std::map<EdgeKey, std::vector<Span>> pieces;
    for (const auto& piece : made.pieces) pieces[{piece.vertices, piece.triangles}].push_back(piece.piece);
    Agreement all;
    std::mutex lock;
    tbb::parallel_for(std::size_t{0}, mesh.edges.size(), [&](std::size_t number) {
        const auto& edge = mesh.edges[number];
        if (edge.triangles[0] == storage::MeshEdge::none || edge.triangles[1] == storage::MeshEdge::none) {
        } else {
            const int one = trial.side(edge.triangles[0]), other = trial.side(edge.triangles[1]);
            if (one * other != -1) return;
        }
        const glm::dvec3 from = trial.inEye(edge.vertices[0]), to = trial.inEye(edge.vertices[1]);
        const glm::dvec2 p = trial.onScreen(from), q = trial.onScreen(to);
        const double length = glm::distance(p, q);
        const int count = std::max(1, static_cast<int>(length / tried));
        const auto found = pieces.find({edge.vertices, edge.triangles});
        Agreement own;
        for (int i = 0; i < count; ++i) {
            const double s = (i + 0.5) / count;
            const glm::dvec2 at = p + s * (q - p);
            if (at.x < 0.0 || at.y < 0.0 || at.x > plan.width || at.y > plan.height) continue;
            const double share = plan.camera.perspective() ? s / to.z / ((1.0 - s) / from.z + s / to.z) : s;
            const bool wanted = trial.seen(from + share * (to - from), edge.triangles);
            const bool has = found != pieces.end() &&
                             std::any_of(found->second.begin(), found->second.end(), [&](const Span& span) {
                                 return span.begin <= share && share <= span.end;
                             });
            if (!wanted && !has) continue;
            own.length += length / count;
            own.missed += wanted && !has ? length / count : 0.0;
            own.hidden += has && !wanted ? length / count : 0.0;
        }
        const std::lock_guard hold(lock);
        all.length += own.length;
        all.missed += own.missed;
        all.hidden += own.hidden;
    });
    fmt::print(
        "silhouettes and borders: {:.0f} pixels long; agree {:.3f}%, missed {:.3f}%, drawn though hidden "
        "{:.3f}%\n",
        all.length, 100.0 * (1.0 - (all.missed + all.hidden) / all.length), 100.0 * all.missed / all.length,
        100.0 * all.hidden / all.length);
}

/// Inside complex regions, the drawing blurred against the target blurred.
void tryTones(const Made& made, const FramePlan& plan, const InkStyle& style) {
    const auto& modalities = made.scene.modalities;
    auto wanted = modalities.grey;
    for (auto& value : wanted.values) value = style.inkIsDark ? 1.0F - value : value;
    const auto target = blurred(wanted, style.reading);
    const auto complexity =
        blurredWithin(render::coverOf(made.scene.lines, plan.width, plan.height, style.silhouettes.width),
                      modalities.depth, modalities.extent, style.reading);
    InkStyle all = style, adjusted = style, hatches = style;
    all.silhouettes.mode = SilhouetteMode::all;
    adjusted.silhouettes.mode = SilhouetteMode::adjusted;
    hatches.silhouettes.mode = SilhouetteMode::none;
    all.hatch.strength = adjusted.hatch.strength = 0.0;
    hatches.hatch.strength = 1.0;
    const auto tone = [&](const InkStyle& of) {
        return blurred(coverOf(drawInk(made.scene, of, 1.0, {}).strokes, plan), style.reading);
    };
    const auto ofAll = tone(all), ofAdjusted = tone(adjusted), ofHatches = tone(hatches),
               ofStyle = tone(style);
    struct Error {
        const char* name;
        const ToneGrid& tone;
        bool lighten;
    };
    for (const auto& [name, drawn, lighten] :
         {Error{"all lines, to lighten", ofAll, true}, Error{"adjusted, to lighten", ofAdjusted, true},
          Error{"hatches, complex", ofHatches, false}, Error{"all lines, complex", ofAll, false},
          Error{"the style, complex", ofStyle, false}}) {
        double off = 0.0, bias = 0.0, count = 0.0;
        for (std::size_t i = 0; i < target.values.size(); ++i) {
            if (complexity.values[i] < static_cast<float>(complexFrom)) continue;
            if (lighten && ofAll.values[i] < target.values[i]) continue;
            const double error = static_cast<double>(drawn.values[i]) - static_cast<double>(target.values[i]);
            off += std::abs(error);
            bias += error;
            count += 1.0;
        }
        fmt::print("tone of {:22}: mean absolute error {:.4f}, mean {:+.4f}, over {:.0f} pixels\n", name,
                   off / count, bias / count, count);
    }
}

/// What each kind of ink does in a film: its own change and share of the ink.
void tellParts(const Film& film) {
    double inked = 0.0;
    for (const auto& part : film.parts()) inked += part.inked;
    for (std::size_t i = 0; i < film.parts().size(); ++i) {
        const auto& part = film.parts()[i];
        if (!(part.inked > 0.0)) continue;
        fmt::print("  {:14} {:5.1f}% of the ink, changes {:.4f}\n", Film::partNames[i],
                   100.0 * part.inked / inked, part.changed / part.inked);
    }
}

/// Ink that came is red, ink that went is blue, what stayed is grey.
void writeChange(const std::string& file, const Raster<float>& was, const Raster<float>& is) {
    std::ofstream out(file, std::ios::binary);
    out << "P6 " << is.width << ' ' << is.height << " 255\n";
    const auto put = [&](float cover) {
        out.put(
            static_cast<char>(static_cast<unsigned char>(255.0F * std::sqrt(std::max(0.0F, 1.0F - cover)))));
    };
    for (std::size_t i = 0; i < is.values.size(); ++i) {
        put(was.values[i]);
        put(std::max(was.values[i], is.values[i]));
        put(is.values[i]);
    }
}

/// All lines that lie in a third of all cubes of space, the same in all pictures: ink that sticks to what it
/// is drawn on.
struct StuckInk {
    Drawing drawing;
    InkMemory memory;

    StuckInk(const InkScene& scene, double width) {
        const glm::dmat4 fromEye = glm::inverse(scene.camera.toEye);
        const double side = 0.02 * scene.modalities.extent;
        const auto isDrawn = [&](const LinePoint& from, const LinePoint& to) {
            const PicturePlace middle{0.5 * (from.at + to.at), 0.5 * (from.depth + to.depth)};
            const glm::dvec3 place =
                glm::floor(glm::dvec3(fromEye * glm::dvec4(scene.camera.inEye(middle), 1.0)) / cubes);
            const auto number = static_cast<std::uint64_t>(static_cast<std::int64_t>(place.x)) * 73856093U ^
                                static_cast<std::uint64_t>(static_cast<std::int64_t>(place.y)) * 19349663U ^
                                static_cast<std::uint64_t>(static_cast<std::int64_t>(place.z)) * 83492791U;
            return (number * 0x9E3779B97F4A7C15U >> 32U) % 3 == 0;
        };
        if (cubes == 0.0) cubes = side;
        for (const auto& line : scene.lines) {
            InkLine part{line.kind, {}, line.rank};
            const auto end = [&] {
                if (part.points.size() > 1) memory.drawn.push_back(part);
                part.points.clear();
            };
            for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
                const auto &from = line.points[i], &to = line.points[i + 1];
                const double parts = std::max(1.0, std::ceil(glm::distance(from.at, to.at)));
                for (double k = 0.0; k < parts; ++k) {
                    const auto at = [&](double share) {
                        return LinePoint{glm::mix(from.at, to.at, share),
                                         std::lerp(from.depth, to.depth, share), from.step};
                    };
                    const auto a = at(k / parts), b = at((k + 1.0) / parts);
                    if (!isDrawn(a, b)) {
                        end();
                        continue;
                    }
                    if (part.points.empty()) part.points.push_back(a);
                    part.points.push_back(b);
                }
            }
            end();
        }
        for (const auto& line : memory.drawn) {
            const auto begin = static_cast<std::uint32_t>(drawing.strokes.points.size());
            for (const auto& point : line.points)
                drawing.strokes.points.push_back({static_cast<float>(point.at.x),
                                                  static_cast<float>(point.at.y), static_cast<float>(width),
                                                  point.depth});
            drawing.strokes.lines.push_back(
                {begin, static_cast<std::uint32_t>(drawing.strokes.points.size())});
        }
    }
    inline static double cubes = 0.0;  // sides, layer units
};

/// The camera turns around its target. `pictures`: a folder for what changes, or nothing.
void tryFilm(const MeshSurface& surface, const Layer& layer, FramePlan plan, double degrees, int frames,
             const std::string& pictures) {
    const auto style = inkStyleOf(*layer.ink(), layer.inkIsDark);
    InkStyle all = style;
    all.silhouettes.mode = SilhouetteMode::all;
    all.hatch.strength = 0.0;
    Film still, coherent, lines, stuck;
    InkMemory memory;
    int shown = 0, drawn = 0;
    if (!pictures.empty())
        coherent.compared = [&](const auto& was, const auto& is) {
            writeChange(fmt::format("{}/change-{:03}.ppm", pictures, ++shown), was, is);
        };
    const auto show = [&](Film& film, const InkScene& scene, const InkStyle& of, InkMemory& kept) {
        const auto drawing = drawInk(scene, of, 1.0, {}, &kept);
        film.show(scene, drawing, kept, plan);
        if (!pictures.empty() && &film == &coherent) {
            const auto cover = coverOf(drawing.strokes, plan);
            writeChange(fmt::format("{}/drawing-{:03}.ppm", pictures, drawn++), cover, cover);
        }
    };
    const glm::dvec3 off = plan.camera.eye - plan.camera.target;
    const glm::dvec3 up = glm::normalize(plan.camera.up);
    for (int i = 0; i < frames; ++i) {
        const double turn = i * degrees * std::numbers::pi / 180.0;
        plan.camera.eye = plan.camera.target + std::cos(turn) * off + std::sin(turn) * glm::cross(up, off) +
                          (1.0 - std::cos(turn)) * glm::dot(up, off) * up;
        auto seen = modalitiesOf(surface, layer.transform, style, plan, {});
        const LineView view(plan, layer.transform);
        const auto edges = linesOf(surface, view, style.silhouettes.crease, {});
        const auto pieces =
            visible(surface, view, edges,
                    {.sampling = sampling, .likely = &seen.triangle, .farthest = &seen.farthest}, {});
        const double extent = seen.modalities.extent;
        const InkScene scene{std::move(seen.modalities), chained(surface, view, pieces, extent, {}),
                             inkCamera(plan, layer)};
        InkMemory none, empty;
        show(still, scene, style, none);
        show(coherent, scene, style, memory);
        show(lines, scene, all, empty);
        const StuckInk ink(scene, style.silhouettes.width);
        stuck.show(scene, ink.drawing, ink.memory, plan);
    }
    fmt::print(
        "film of {} pictures, {} degrees each: ink that changes {:.4f} of independent pictures, {:.4f} of "
        "coherent ones, {:.4f} of all lines alone, {:.4f} of ink that sticks\n",
        frames, degrees, still.flicker(), coherent.flicker(), lines.flicker(), stuck.flicker());
    fmt::print(
        "of the {:.0f}% that nothing hides within a pixel: {:.4f} of independent pictures, {:.4f} of "
        "coherent ones, {:.4f} of ink that sticks\n",
        100.0 * coherent.inFront(), still.flickerInFront(), coherent.flickerInFront(),
        stuck.flickerInFront());
    fmt::print("the last picture has {:.1f}% more ink as a coherent one\n",
               100.0 * (coherent.ink() / still.ink() - 1.0));
    tellParts(coherent);
}

int run(int count, char** arguments) {
    if (count < 3) {
        fmt::print(stderr,
                   "bench-ink NAME.mote VIEW.json [--lines] [--tones] [--times N] [--film DEGREES FRAMES] "
                   "[--quick]\n");
        return 2;
    }
    const MeshSurface surface = read(arguments[1]);
    auto view = readView(arguments[2]);
    bool lines = false, tones = false, quick = false;
    int times = 1, frames = 0;
    double degrees = 0.0;
    std::string pictures;
    for (int i = 3; i < count; ++i) {
        const std::string word = arguments[i];
        lines |= word == "--lines";
        tones |= word == "--tones";
        quick |= word == "--quick";
        if (word == "--times" && i + 1 < count) times = std::atoi(arguments[++i]);
        if (word == "--pictures" && i + 1 < count) pictures = arguments[++i];
        if (word == "--film" && i + 2 < count) {
            degrees = std::atof(arguments[++i]);
            frames = std::atoi(arguments[++i]);
        }
    }
    FramePlan plan;
    plan.exact = !quick;
    plan.width = quick ? static_cast<std::uint32_t>(view.width * quickScale) : view.width;
    plan.height = quick ? static_cast<std::uint32_t>(view.height * quickScale) : view.height;
    plan.camera = view.cameraFitted ? fitCamera(surface.bounds(), view.aspect()) : view.camera;
    Made made;
    for (int i = 0; i < times; ++i) made = draw(surface, view.layers[0], plan);
    if (lines) tryLines(surface, made, plan);
    if (tones) tryTones(made, plan, inkStyleOf(*view.layers[0].ink(), view.layers[0].inkIsDark));
    if (frames > 1) tryFilm(surface, view.layers[0], plan, degrees, frames, pictures);
    return 0;
}

}  // namespace
}  // namespace mote::bench

int main(int count, char** arguments) {
    return mote::bench::run(count, arguments);
}
