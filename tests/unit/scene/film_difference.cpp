// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/scene/film_difference.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "protocol/scene/curve_presets.h"
#include "protocol/scene/film/legal_camera.h"
#include "protocol/scene/mix.h"
#include "protocol/scene/view_message.h"

namespace mote::test {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

/// A layer without its curves: its numbers in order, and all else as a text by which layers are told apart.
struct Contents {
    std::string words;
    std::vector<double> numbers;
};

/// A field that is neither a number to be compared nor a message; ids are all that is repeated.
std::string wordOf(const Message& message, const FieldDescriptor& field, int index) {
    const auto& reflection = *message.GetReflection();
    if (field.is_repeated())
        return std::to_string(reflection.GetRepeatedUInt64(message, &field, index)) + ";";
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING)
        return reflection.GetString(message, &field) + ";";
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_BOOL)
        return reflection.GetBool(message, &field) ? "1;" : "0;";
    return std::to_string(reflection.GetUInt32(message, &field)) + ";";
}

void collect(const Message& message, Contents& out) {
    const auto& reflection = *message.GetReflection();
    for (int index = 0; index < message.GetDescriptor()->field_count(); ++index) {
        const auto* const field = message.GetDescriptor()->field(index);
        if (field->has_presence() && !reflection.HasField(message, field)) continue;
        if (field->message_type() == proto::Selection::descriptor()) {
            out.words += reflection.GetMessage(message, field).SerializeAsString();
            continue;
        }
        const bool number = field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE;
        const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
        out.words += field->name() + std::to_string(count) + ";";
        for (int i = 0; i < count; ++i) {
            if (number) {
                out.numbers.push_back(field->is_repeated() ? reflection.GetRepeatedDouble(message, field, i)
                                                           : reflection.GetDouble(message, field));
            } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
                collect(field->is_repeated() ? reflection.GetRepeatedMessage(message, field, i)
                                             : reflection.GetMessage(message, field),
                        out);
            } else {
                out.words += wordOf(message, *field, i);
            }
        }
    }
}

/// A layer's curves, one after the other.
std::vector<ColoredCurve> curvesOf(const Layer& layer) {
    if (layer.particles()) {
        const auto style = particlesStyleOf(*layer.particles());
        return {{style.volumeOpacity}, {style.pointFraction}};
    }
    if (layer.hybrid() && !layer.hybrid()->curve().empty()) {
        const auto style = hybridStyleOf(*layer.hybrid());
        return {{*style.opacity, style.colors}};
    }
    if (layer.ink() && !layer.ink()->curve().empty()) return {{*inkStyleOf(*layer.ink()).opacity}};
    return {};
}

/// All but the curves, with what they say of the colours' range said by itself.
Layer withoutCurves(Layer layer) {
    if (auto* const particles = layer.particles(); particles && !particles->volume().curve().empty()) {
        particles->mutable_volume()->clear_curve();
        particles->mutable_volume()->add_curve()->set_opacity(0.5);
        particles->mutable_points()->set_linked(true);
        particles->mutable_points()->clear_curve();
    }
    if (auto* const ink = std::get_if<proto::InkStyle>(&layer.style)) {
        if (!ink->curve().empty()) ink->mutable_curve()->DeleteSubrange(1, ink->curve_size() - 1);
        if (!ink->curve().empty()) *ink->mutable_curve(0) = {};
        // Without a strength there is none.
        ink->mutable_ink()->set_strength(0.5);
        ink->mutable_ink()->set_complexity(0.3);
        *ink->mutable_wash() = {};
    }
    auto* const hybrid = std::get_if<proto::HybridStyle>(&layer.style);
    if (hybrid == nullptr || hybrid->curve().empty()) return layer;
    const double low = hybrid->curve(0).value(), high = hybrid->curve(hybrid->curve_size() - 1).value();
    const bool colored = !hybrid->curve(0).color().empty();
    if (hybrid->color_range().empty() && !colored && low < high) {
        const auto range = hybrid->color_map().empty() ? readableColors({low, high}) : ValueRange{low, high};
        for (const double end : {range.low, range.high}) hybrid->add_color_range(end);
    }
    hybrid->clear_curve();
    auto& knot = *hybrid->add_curve();
    if (colored) knot.mutable_color()->Resize(3, 0.0);
    return layer;
}

double knotsApart(const Curve& a, const Curve& b) {
    const auto &ka = a.knots(), &kb = b.knots();
    if (ka.size() != kb.size()) return 1.0;
    double most = 0.0;
    for (std::size_t i = 0; i < ka.size(); ++i)
        most = std::max({most, std::abs(ka[i].x - kb[i].x), std::abs(ka[i].y - kb[i].y)});
    return most;
}

/// Of their values, on average. A step that moves a little differs little; and curves may be alike with other
/// knots.
double valuesApart(const Curve& a, const Curve& b) {
    constexpr int samples = 500;
    const double low = std::min(a.knots().front().x, b.knots().front().x);
    const double high = std::max(a.knots().back().x, b.knots().back().x);
    double sum = 0.0;
    for (int i = 0; i < samples; ++i) {
        const double x = low + (high - low) * (i + 0.5) / samples;
        sum += std::abs(a(x) - b(x));
    }
    return sum / samples;
}

double differenceOf(const Curve& a, const Curve& b) {
    return std::min(knotsApart(a, b), valuesApart(a, b));
}

double numbersApart(const std::vector<double>& a, const std::vector<double>& b) {
    double most = 0.0;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
        most = std::max(most, std::abs(a[i] - b[i]));
    return a.size() == b.size() ? most : 1.0;
}

struct Shown {
    std::string words;
    double opacity = 0.0;
    std::vector<double> numbers;
    std::vector<ColoredCurve> curves;
};

/// What is shown of it in a step alone, of one and the other.
std::vector<Layer> inSteps(const Layer& layer) {
    if (!layer.towards) return {layer};
    const auto shown = [&](std::uint32_t step, double share) {
        Layer one = layer;
        one.step = step;
        one.opacity *= share;
        one.towards.reset();
        return one;
    };
    const auto& [step, share] = *layer.towards;
    if (step == layer.step) return {shown(step, 1.0)};
    std::vector<Layer> both;
    if (share < 1.0) both.push_back(shown(layer.step, 1.0 - share));
    if (share > 0.0) both.push_back(shown(step, share));
    return both;
}

/// The most visible first.
std::vector<Shown> shownBy(const View& view) {
    std::vector<Layer> layers;
    for (const auto& layer : view.layers) {
        for (auto& one : inSteps(layer)) layers.push_back(std::move(one));
    }
    std::vector<Shown> all;
    for (const auto& layer : layers) {
        Layer bare = withoutCurves(layer);
        bare.opacity = 1.0;
        bare.transform = glm::dmat4(1.0);
        View alone;
        alone.background = view.background;
        alone.layers = {bare};
        Contents contents;
        collect(toProto(alone).layers(0), contents);
        for (int i = 0; i < 16; ++i) contents.numbers.push_back(layer.transform[i / 4][i % 4]);
        if (layer.ink()) {
            const auto style = inkStyleOf(*layer.ink());
            contents.numbers.push_back(style.solid.strength * style.solid.complexity);
            const double washed = style.wash.everywhere ? style.wash.strength : 0.0;
            for (int i = 0; i < 3; ++i) contents.numbers.push_back(washed * style.wash.color[i]);
            contents.numbers.push_back(washed * style.wash.edges);
            contents.numbers.push_back(washed * style.wash.granulation);
        }
        all.push_back({layer.dataset + "#" + std::to_string(layer.step) + contents.words, layer.opacity,
                       contents.numbers, curvesOf(layer)});
    }
    std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.opacity > b.opacity; });
    return all;
}

double differenceOf(const Shown& a, const Shown& b) {
    const double opacity = std::abs(a.opacity - b.opacity);
    if (std::min(a.opacity, b.opacity) < 1e-3) return opacity;
    double most = std::max(opacity, numbersApart(a.numbers, b.numbers));
    for (std::size_t i = 0; i < std::min(a.curves.size(), b.curves.size()); ++i)
        most = std::max(most, differenceOf(a.curves[i].curve, b.curves[i].curve));
    return most;
}

/// Relative to how far off it is.
double differenceOf(const Camera& a, const Camera& b) {
    const double scale = std::min(glm::distance(a.eye, a.target), glm::distance(b.eye, b.target));
    const auto one = orientationOf(a), other = orientationOf(b);
    const double turned = 1.0 - std::abs(glm::dot(one, other));
    const double lens = std::abs(std::log(a.halfHeight() / b.halfHeight()));
    const double moved = std::max(glm::distance(a.eye, b.eye), glm::distance(a.target, b.target)) / scale;
    // Between a parallel projection and a long lens, there is the way of the eye.
    return a.perspective() == b.perspective() ? std::max({std::sqrt(turned), lens, moved}) : 0.0;
}

}  // namespace

double difference(const View& a, const View& b) {
    double most = std::max(differenceOf(a.camera, b.camera), glm::distance(a.background, b.background));
    auto second = shownBy(b);
    for (const auto& shown : shownBy(a)) {
        const auto alike = std::partition(second.begin(), second.end(),
                                          [&](const auto& other) { return other.words == shown.words; });
        const auto nearest = std::min_element(second.begin(), alike, [&](const auto& x, const auto& y) {
            return differenceOf(shown, x) < differenceOf(shown, y);
        });
        most = std::max(most, nearest == alike ? shown.opacity : differenceOf(shown, *nearest));
        if (nearest != alike) second.erase(nearest);
    }
    for (const auto& shown : second) most = std::max(most, shown.opacity);
    return most;
}

}  // namespace mote::test
