// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/shrinker.h"

#include <cmath>
#include <vector>

#include "protocol/scene/view.h"

namespace mote::test {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

/// A number with so many significant decimal digits.
double rounded(double value, int digits) {
    if (value == 0.0 || !std::isfinite(value)) return value;
    const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) + 1 - digits);
    return std::round(value / unit) * unit;
}

/// Whether a field's numbers go together: three of a vector, sixteen of a matrix.
bool isVector(const FieldDescriptor* field) {
    return field->is_repeated() && field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE;
}

class Shrinker {
  public:
    Shrinker(const proto::View& view, const Fails& fails, int questions)
        : best_(view), fails_(fails), left_(questions) {}

    proto::View run() {
        while (left_ > 0) {
            const auto before = best_.SerializeAsString();
            dropParts(&best_);
            shrinkPicture();
            for (const int digits : {1, 2, 4}) roundNumbers(&best_, digits);
            if (best_.SerializeAsString() == before) break;
        }
        return best_;
    }

  private:
    /// Whether what was changed in the best view still fails; else it is undone. The message that was changed
    /// lies in the best view, so it is copied back in place.
    template <class Change>
    bool attempt(Message* part, const Change& change) {
        const std::unique_ptr<Message> before(part->New());
        before->CopyFrom(*part);
        change();
        const bool same = before->SerializeAsString() == part->SerializeAsString();
        if (!same && left_ > 0 && parseView(best_).ok()) {
            --left_;
            if (fails_(best_)) return true;
        }
        part->CopyFrom(*before);
        return false;
    }

    void dropParts(Message* message) {
        const Reflection* const reflection = message->GetReflection();
        std::vector<const FieldDescriptor*> fields;
        reflection->ListFields(*message, &fields);
        for (const auto* const field : fields) {
            if (attempt(message, [&] { reflection->ClearField(message, field); })) continue;
            if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
            if (!field->is_repeated()) {
                dropParts(reflection->MutableMessage(message, field));
                continue;
            }
            dropElements(message, field);
        }
    }

    void dropElements(Message* message, const FieldDescriptor* field) {
        const Reflection* const reflection = message->GetReflection();
        for (int i = reflection->FieldSize(*message, field) - 1; i >= 0; --i) {
            const auto drop = [&] {
                for (int k = i; k + 1 < reflection->FieldSize(*message, field); ++k)
                    reflection->SwapElements(message, field, k, k + 1);
                reflection->RemoveLast(message, field);
            };
            if (!attempt(message, drop)) dropParts(reflection->MutableRepeatedMessage(message, field, i));
        }
    }

    void shrinkPicture() {
        for (const auto side : {best_.width(), best_.height()}) {
            for (std::uint32_t smaller = 1; smaller < side; smaller *= 2) {
                const auto narrow = [&] { best_.set_width(std::min(best_.width(), smaller)); };
                const auto low = [&] { best_.set_height(std::min(best_.height(), smaller)); };
                if (attempt(&best_, [&] { narrow(), low(); })) return;
                if (attempt(&best_, narrow) || attempt(&best_, low)) return;
            }
        }
    }

    void roundNumbers(Message* message, int digits) {
        const Reflection* const reflection = message->GetReflection();
        std::vector<const FieldDescriptor*> fields;
        reflection->ListFields(*message, &fields);
        for (const auto* const field : fields) {
            if (field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) roundField(message, field, digits);
            if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
            if (!field->is_repeated()) {
                roundNumbers(reflection->MutableMessage(message, field), digits);
                continue;
            }
            for (int i = 0; i < reflection->FieldSize(*message, field); ++i)
                roundNumbers(reflection->MutableRepeatedMessage(message, field, i), digits);
        }
    }

    void roundField(Message* message, const FieldDescriptor* field, int digits) {
        const Reflection* const reflection = message->GetReflection();
        if (!isVector(field)) {
            const double value = reflection->GetDouble(*message, field);
            attempt(message, [&] { reflection->SetDouble(message, field, rounded(value, digits)); });
            return;
        }
        for (int i = 0; i < reflection->FieldSize(*message, field); ++i) {
            const double value = reflection->GetRepeatedDouble(*message, field, i);
            const auto set = [&](double other) {
                return attempt(message, [&] { reflection->SetRepeatedDouble(message, field, i, other); });
            };
            if (!set(0.0)) set(rounded(value, digits));
        }
    }

    proto::View best_;
    const Fails& fails_;
    int left_;
};

}  // namespace

proto::View shrunk(const proto::View& view, const Fails& fails, int mostQuestions) {
    return Shrinker(view, fails, mostQuestions).run();
}

}  // namespace mote::test
