// A scene as a Protobuf message, and back: both walk over the fields of its structs.
#pragma once

#include <google/protobuf/message.h>

#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "afferent/scene/fields.hpp"

namespace afferent {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

template <class T>
inline constexpr bool is_vector = false;
template <class T>
inline constexpr bool is_vector<std::vector<T>> = true;
template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;
template <class T>
inline constexpr bool is_variant = false;
template <class... T>
inline constexpr bool is_variant<std::variant<T...>> = true;
template <class T>
inline constexpr bool is_scalar =
    std::is_arithmetic_v<T> || std::is_enum_v<T> || std::is_same_v<T, std::string>;

inline const FieldDescriptor& field_of(const Message& message, const char* name) {
    return *message.GetDescriptor()->FindFieldByName(name);
}

// Fills a struct from its message; fields that the message does not have keep their defaults. Enumerations
// are read and written by their number.
class Reader {
  public:
    explicit Reader(const Message& message) : message_(message), reflection_(*message.GetReflection()) {}

    template <class T>
    void operator()(const char* name, T& member) const {
        const FieldDescriptor& field = field_of(message_, name);
        if constexpr (is_vector<T>) {
            const int size = reflection_.FieldSize(message_, &field);
            if (size == 0) return;
            member.assign(static_cast<std::size_t>(size), {});
            for (int i = 0; i < size; ++i) read(field, i, member[static_cast<std::size_t>(i)]);
        } else if (reflection_.HasField(message_, &field)) {
            if constexpr (is_optional<T>)
                read(field, -1, *(member = typename T::value_type{}));
            else
                read(field, -1, member);
        }
    }

    template <class Variant>
    void arms(Variant& variant) const {
        arms(variant, std::make_index_sequence<std::variant_size_v<Variant>>());
    }

  private:
    template <class Variant, std::size_t... I>
    void arms(Variant& variant, std::index_sequence<I...>) const {
        (read_arm<I>(variant), ...);
    }

    template <std::size_t I, class Variant>
    void read_arm(Variant& variant) const {
        using Arm = std::variant_alternative_t<I, Variant>;
        const char* name = alternative_names<Variant>[I];
        if (!*name) {
            Arm arm;
            each_field(arm, *this);
            if (!(arm == Arm{})) variant = std::move(arm);
            return;
        }
        const FieldDescriptor& field = field_of(message_, name);
        if (!reflection_.HasField(message_, &field)) return;
        variant = Arm{};
        read(field, -1, std::get<I>(variant));
    }

    // The index-th of a repeated field; index -1: the only one.
    template <class T>
    void read(const FieldDescriptor& field, int index, T& value) const {
        if constexpr (is_variant<T>)
            Reader(sub_message(field, index)).arms(value);
        else if constexpr (!is_scalar<T>)
            each_field(value, Reader(sub_message(field, index)));
        else
            value = scalar<T>(field, index);
    }

    const Message& sub_message(const FieldDescriptor& field, int index) const {
        return index < 0 ? reflection_.GetMessage(message_, &field)
                         : reflection_.GetRepeatedMessage(message_, &field, index);
    }

    template <class T>
    T scalar(const FieldDescriptor& field, int index) const {
        const auto get = [&](auto single, auto repeated) {
            return index < 0 ? (reflection_.*single)(message_, &field)
                             : (reflection_.*repeated)(message_, &field, index);
        };
        if constexpr (std::is_same_v<T, bool>)
            return get(&Reflection::GetBool, &Reflection::GetRepeatedBool);
        else if constexpr (std::is_same_v<T, double>)
            return get(&Reflection::GetDouble, &Reflection::GetRepeatedDouble);
        else if constexpr (std::is_same_v<T, std::uint32_t>)
            return get(&Reflection::GetUInt32, &Reflection::GetRepeatedUInt32);
        else if constexpr (std::is_same_v<T, std::uint64_t>)
            return get(&Reflection::GetUInt64, &Reflection::GetRepeatedUInt64);
        else if constexpr (std::is_same_v<T, std::string>)
            return get(&Reflection::GetString, &Reflection::GetRepeatedString);
        else
            return static_cast<T>(get(&Reflection::GetEnumValue, &Reflection::GetRepeatedEnumValue));
    }

    const Message& message_;
    const Reflection& reflection_;
};

// Fills a message from a struct. Fields at their defaults are left out; an optional that has a value is
// written, whatever the value.
class Writer {
  public:
    explicit Writer(Message& message) : message_(message), reflection_(*message.GetReflection()) {}

    template <class T>
    void operator()(const char* name, const T& member) const {
        const FieldDescriptor& field = field_of(message_, name);
        if constexpr (is_vector<T>) {
            for (const auto& value : member) add(field, value);
        } else if constexpr (is_optional<T>) {
            if (member) set(field, *member);
        } else if constexpr (is_scalar<T>) {
            if (member != default_of<T>(field)) set(field, member);
        } else {
            set(field, member);
            if (reflection_.GetMessage(message_, &field).ByteSizeLong() == 0)
                reflection_.ClearField(&message_, &field);
        }
    }

    template <class Variant>
    void arms(const Variant& variant) const {
        const char* name = alternative_names<Variant>[variant.index()];
        if (!*name) return std::visit([&](const auto& arm) { each_field(arm, *this); }, variant);
        const FieldDescriptor& field = field_of(message_, name);
        std::visit([&](const auto& arm) { set(field, arm); }, variant);
        const bool is_default =
            variant.index() == 0 && reflection_.GetMessage(message_, &field).ByteSizeLong() == 0;
        if (is_default) reflection_.ClearField(&message_, &field);
    }

  private:
    template <class T>
    static T default_of(const FieldDescriptor& field) {
        if constexpr (std::is_same_v<T, bool>)
            return field.default_value_bool();
        else if constexpr (std::is_same_v<T, double>)
            return field.default_value_double();
        else if constexpr (std::is_same_v<T, std::uint32_t>)
            return field.default_value_uint32();
        else if constexpr (std::is_same_v<T, std::uint64_t>)
            return field.default_value_uint64();
        else if constexpr (std::is_same_v<T, std::string>)
            return field.default_value_string();
        else
            return static_cast<T>(field.default_value_enum()->number());
    }

    template <class T>
    void fill(Message& message, const T& value) const {
        if constexpr (is_variant<T>)
            Writer(message).arms(value);
        else
            each_field(value, Writer(message));
    }

    template <class T>
    void set(const FieldDescriptor& field, const T& value) const {
        if constexpr (std::is_same_v<T, bool>)
            reflection_.SetBool(&message_, &field, value);
        else if constexpr (std::is_same_v<T, double>)
            reflection_.SetDouble(&message_, &field, value);
        else if constexpr (std::is_same_v<T, std::uint32_t>)
            reflection_.SetUInt32(&message_, &field, value);
        else if constexpr (std::is_same_v<T, std::uint64_t>)
            reflection_.SetUInt64(&message_, &field, value);
        else if constexpr (std::is_same_v<T, std::string>)
            reflection_.SetString(&message_, &field, value);
        else if constexpr (std::is_enum_v<T>)
            reflection_.SetEnumValue(&message_, &field, static_cast<int>(value));
        else
            fill(*reflection_.MutableMessage(&message_, &field), value);
    }

    template <class T>
    void add(const FieldDescriptor& field, const T& value) const {
        if constexpr (std::is_same_v<T, double>)
            reflection_.AddDouble(&message_, &field, value);
        else if constexpr (std::is_same_v<T, std::uint32_t>)
            reflection_.AddUInt32(&message_, &field, value);
        else if constexpr (std::is_same_v<T, std::string>)
            reflection_.AddString(&message_, &field, value);
        else
            fill(*reflection_.AddMessage(&message_, &field), value);
    }

    Message& message_;
    const Reflection& reflection_;
};

}  // namespace afferent
