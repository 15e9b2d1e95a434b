#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "calib/base/yaml_value.hpp"
#include "samples/simulator/scene_fields.hpp"

namespace ceilmap::simulator {

/// How the groups of a scene file are read: fields by their tables, rows of numbers, kinds.

template <typename Group, std::size_t N, typename... Others>
void AllowOnly(const YamlValue& value,
               const std::array<Field<Group>, N>& fields,
               const Others&... others) {
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    value.AllowOnly({fields[I].key..., std::string_view(others)...});
  }
  (std::make_index_sequence<N>());
}

inline bool ReadBool(const YamlValue& value) {
  const std::string text = value.Text();
  if (text != "true" && text != "false") value.Fail("true or false", "correct it");
  return text == "true";
}

template <typename Group>
void ReadField(const YamlValue& value, const Field<Group>& field, Group& group) {
  std::visit(
      [&](auto member) {
        if constexpr (std::is_same_v<decltype(member), bool Group::*>) {
          group.*member = ReadBool(value);
        } else if constexpr (std::is_same_v<decltype(member), int Group::*>) {
          group.*member =
              value.WholeNumber(static_cast<int>(field.least), static_cast<int>(field.most));
        } else {
          group.*member = value.Number();
          if (!(group.*member >= field.least && group.*member <= field.most)) {
            value.Fail(RangeText(field.least, field.most), "correct the value");
          }
        }
      },
      field.member);
}

/// @param kind_bit  Of the group's kind. @param kind_name  Its name for messages.
template <typename Group, std::size_t N>
void ReadFields(const YamlValue& value,
                const std::array<Field<Group>, N>& fields,
                Group& group,
                unsigned kind_bit = kEveryKind,
                std::string_view kind_name = {}) {
  for (const Field<Group>& field : fields) {
    const auto given = value.Find(field.key);
    if (!given) continue;
    if ((field.kinds & kind_bit) == 0) {
      given->Fail(fmt::format("absent for kind {}", kind_name),
                  "remove it, it would have no effect");
    }
    ReadField(*given, field, group);
  }
}

template <typename Kind, std::size_t N>
void ReadKind(const YamlValue& value,
              const std::array<std::string_view, N>& names,
              Kind& kind,
              std::string_view key = "kind") {
  const auto given = value.Find(key);
  if (!given) return;
  const std::string text = given->Text();
  for (std::size_t i = 0; i < N; ++i) {
    if (text != names[i]) continue;
    kind = static_cast<Kind>(i);
    return;
  }
  given->Fail(fmt::format("one of {}", fmt::join(names, ", ")), "correct it");
}

/// A list of numbers as rows of `Columns`, calling `add` with each.
template <std::size_t Columns, typename Add>
void ReadRows(const YamlValue& value,
              std::string_view key,
              std::string_view columns,
              const Add& add) {
  const auto given = value.Find(key);
  if (!given) return;
  const std::size_t count = given->ListSize();
  if (count % Columns != 0) {
    given->Fail(fmt::format("rows of {} numbers ({}), not {} numbers", Columns, columns, count),
                "complete the last row");
  }
  const std::vector<double> numbers = given->Numbers(count);
  for (std::size_t i = 0; i < count; i += Columns) add(&numbers[i]);
}

/// Sets the fields of a row of `list`. Values out of range are reported here, where their line is
/// known.
template <typename Row, std::size_t N>
void SetRow(const YamlValue& list,
            const std::array<Field<Row>, N>& fields,
            const double* numbers,
            Row& row) {
  for (const Field<Row>& field : fields) {
    const double number = *numbers++;
    row.*std::get<double Row::*>(field.member) = number;
    if (number >= field.least && number <= field.most) continue;
    list.Fail(fmt::format("rows with {} {}", field.key, RangeText(field.least, field.most)),
              fmt::format("correct {:g}", number));
  }
}

/// Rows of the numbers of `fields`, in their order.
template <typename Row, std::size_t N>
void ReadFieldRows(const YamlValue& value,
                   std::string_view key,
                   std::string_view columns,
                   const std::array<Field<Row>, N>& fields,
                   std::vector<Row>& rows) {
  ReadRows<N>(value, key, columns, [&](const double* numbers) {
    Row row;
    SetRow(value.At(key, ""), fields, numbers, row);
    rows.push_back(row);
  });
}

template <std::size_t N>
void ReadArray(const YamlValue& value, std::string_view key, std::array<double, N>& numbers) {
  const auto given = value.Find(key);
  if (!given) return;
  const std::vector<double> read = given->Numbers(N);
  std::copy(read.begin(), read.end(), numbers.begin());
}

/// A key of one kind only.
inline void RefuseUnless(bool used,
                         const YamlValue& value,
                         const char* key,
                         std::string_view kind) {
  const auto given = value.Find(key);
  if (given && !used) {
    given->Fail(fmt::format("absent for kind {}", kind), "remove it, it would have no effect");
  }
}

}  // namespace ceilmap::simulator
