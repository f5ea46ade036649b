// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/lengths_in_pixels.h"

#include <fmt/format.h>

#include <optional>
#include <string>

#include "protocol/scene/layer_parts.h"

namespace mote {
namespace {

/// Sees lengths alone.
class LengthVisitor : public FieldVisitor {
  public:
    LengthVisitor(std::uint32_t height, double scale) : height_(height), scale_(scale) {}
    void between(const std::function<void(double)>&) override {}
    void word(bool) override {}

  protected:
    std::uint32_t height_;
    double scale_;
};

class Resolver : public LengthVisitor {
  public:
    using FieldVisitor::pixels;
    using LengthVisitor::LengthVisitor;
    void pixels(ScreenLength& value, const ScreenLength&, const LengthField& field) override {
        value = field.inPixels(value, height_, scale_);
    }
};

class Checker : public LengthVisitor {
  public:
    using FieldVisitor::pixels;
    using LengthVisitor::LengthVisitor;
    void pixels(ScreenLength& value, const ScreenLength&, const LengthField& field) override {
        if (error || !value.said() || value * scale_ <= field.greatest) return;
        error = Error{ErrorCode::invalidArgument, std::string(field.path),
                      fmt::format("{} times the view's scale of {} is more than {} pixels", value.value(),
                                  scale_, field.greatest)};
    }

    std::optional<Error> error;
};

}  // namespace

View lengthsInPixels(View view) {
    Resolver resolver(view.height, view.scale);
    for (auto& layer : view.layers) visitLayer(layer, layer, resolver);
    if (view.annotations) view.annotations = inPixels(*view.annotations, view.width, view.height, view.scale);
    view.scale = 1.0;
    return view;
}

Status checkLengths(const View& view) {
    if (view.scale <= 1.0) return success();
    for (std::size_t i = 0; i < view.layers.size(); ++i) {
        Checker checker(view.height, view.scale);
        Layer layer = view.layers[i];
        visitLayer(layer, layer, checker);
        if (checker.error) return checker.error->within(fmt::format("layers[{}]", i));
    }
    return success();
}

}  // namespace mote
