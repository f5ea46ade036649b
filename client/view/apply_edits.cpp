// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/apply_edits.h"

#include <google/protobuf/text_format.h>

#include <algorithm>
#include <memory>
#include <string>

#include "protocol/base/mote_check.h"

namespace mote::client {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

bool isMessage(const FieldDescriptor& field) {
    return field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
}

bool isSame(const Message& one, const Message& other) {
    return one.ByteSizeLong() == other.ByteSizeLong() && one.SerializeAsString() == other.SerializeAsString();
}

const Message& element(const Message& message, const FieldDescriptor& field, int index) {
    return message.GetReflection()->GetRepeatedMessage(message, &field, index);
}

/// `index`: in a list; -1: of a field that is none.
bool isSameValue(const Message& one, const Message& other, const FieldDescriptor& field, int index) {
    if (isMessage(field) && index >= 0)
        return isSame(element(one, field, index), element(other, field, index));
    if (isMessage(field)) {
        return isSame(one.GetReflection()->GetMessage(one, &field),
                      other.GetReflection()->GetMessage(other, &field));
    }
    std::string text, otherText;  // to the last digit
    google::protobuf::TextFormat::PrintFieldValueToString(one, &field, index, &text);
    google::protobuf::TextFormat::PrintFieldValueToString(other, &field, index, &otherText);
    return text == otherText;
}

bool isSameField(const Message& one, const Message& other, const FieldDescriptor& field) {
    const auto &ones = *one.GetReflection(), &others = *other.GetReflection();
    if (!field.is_repeated()) {
        const bool there = ones.HasField(one, &field);
        return there == others.HasField(other, &field) && (!there || isSameValue(one, other, field, -1));
    }
    const int size = ones.FieldSize(one, &field);
    if (size != others.FieldSize(other, &field)) return false;
    for (int i = 0; i < size; ++i) {
        if (!isSameValue(one, other, field, i)) return false;
    }
    return true;
}

/// Of one message to another of its type, whether it is there or not.
void copyField(const Message& from, const FieldDescriptor& field, Message& to) {
    std::unique_ptr<Message> copy(from.New());
    copy->CopyFrom(from);
    to.GetReflection()->SwapFields(&to, copy.get(), {&field});
}

/// How many elements the lists have in common at their beginnings, or (`back`) at their ends.
int commonCount(const Message& one, const Message& other, const FieldDescriptor& field, int most, bool back) {
    const int oneSize = one.GetReflection()->FieldSize(one, &field);
    const int otherSize = other.GetReflection()->FieldSize(other, &field);
    int count = 0;
    const auto place = [&](int size) { return back ? size - 1 - count : count; };
    while (count < std::min({oneSize, otherSize, most}) &&
           isSame(element(one, field, place(oneSize)), element(other, field, place(otherSize))))
        ++count;
    return count;
}

/// Elements came or went: those before and behind them stay.
void exchangeElements(const Message& before, const Message& after, const FieldDescriptor& field,
                      Message& message) {
    const auto& reflection = *message.GetReflection();
    const int all = reflection.FieldSize(before, &field), wanted = reflection.FieldSize(after, &field);
    const int head = commonCount(before, after, field, all, false);
    const int tail = commonCount(before, after, field, std::min(all, wanted) - head, true);
    std::unique_ptr<Message> made(message.New());
    for (int i = 0; i < wanted; ++i) {
        const bool tailed = i >= wanted - tail;
        const auto& from = i < head || tailed ? message : after;
        reflection.AddMessage(made.get(), &field)
            ->CopyFrom(element(from, field, tailed ? i - wanted + all : i));
    }
    reflection.ClearField(&message, &field);
    reflection.SwapFields(&message, made.get(), {&field});
}

void editList(const Message& before, const Message& after, const FieldDescriptor& field, Message& message) {
    const auto& reflection = *message.GetReflection();
    const int all = reflection.FieldSize(before, &field);
    if (!isMessage(field) || reflection.FieldSize(message, &field) != all)
        return copyField(after, field, message);
    if (reflection.FieldSize(after, &field) != all) return exchangeElements(before, after, field, message);
    for (int i = 0; i < all; ++i) {
        applyEdits(element(before, field, i), element(after, field, i),
                   *reflection.MutableRepeatedMessage(&message, &field, i));
    }
}

void editField(const Message& before, const Message& after, const FieldDescriptor& field, Message& message) {
    if (isSameField(before, after, field)) return;
    const auto& reflection = *message.GetReflection();
    if (field.is_repeated()) return editList(before, after, field, message);
    const bool within =
        isMessage(field) && reflection.HasField(before, &field) && reflection.HasField(after, &field);
    if (!within) return copyField(after, field, message);
    applyEdits(reflection.GetMessage(before, &field), reflection.GetMessage(after, &field),
               *reflection.MutableMessage(&message, &field));
}

}  // namespace

void applyEdits(const Message& before, const Message& after, Message& message) {
    MOTE_CHECK(before.GetDescriptor() == after.GetDescriptor() &&
               message.GetDescriptor() == after.GetDescriptor());
    if (isSame(before, after)) return;
    for (int i = 0; i < after.GetDescriptor()->field_count(); ++i)
        editField(before, after, *after.GetDescriptor()->field(i), message);
}

}  // namespace mote::client
