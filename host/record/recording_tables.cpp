#include "host/record/recording_tables.hpp"

#include <cstddef>

namespace lockstep {

h5::Handle step_row_type() {
  h5::Handle type(H5Tcreate(H5T_COMPOUND, sizeof(StepRow)));
  h5::check(H5Tinsert(type, "step", offsetof(StepRow, step), H5T_STD_U32LE));
  h5::check(H5Tinsert(type, "pairs", offsetof(StepRow, pairs), H5T_STD_U32LE));
  h5::check(H5Tinsert(type, "contacts", offsetof(StepRow, contacts), H5T_STD_U32LE));
  h5::check(H5Tinsert(type, "redone", offsetof(StepRow, redone), H5T_STD_U32LE));
  h5::check(H5Tinsert(type, "milliseconds", offsetof(StepRow, milliseconds), H5T_IEEE_F64LE));
  return type;
}

h5::Handle measure_row_type() {
  h5::Handle type(H5Tcreate(H5T_COMPOUND, sizeof(MeasureRow)));
  for (const MeasureColumn& column : measure_columns) {
    const MeasureRow row;
    const auto offset = reinterpret_cast<const char*>(&(row.*column.member)) - reinterpret_cast<const char*>(&row);
    h5::check(H5Tinsert(type, column.name, static_cast<std::size_t>(offset), H5T_IEEE_F64LE));
  }
  return type;
}

h5::Handle contact_force_row_type() {
  constexpr hsize_t three = 3;
  const h5::Handle vector(H5Tarray_create2(H5T_IEEE_F64LE, 1, &three));
  h5::Handle type(H5Tcreate(H5T_COMPOUND, sizeof(ContactForceRow)));
  h5::check(H5Tinsert(type, "body_a", offsetof(ContactForceRow, body_a), H5T_STD_U32LE));
  h5::check(H5Tinsert(type, "body_b", offsetof(ContactForceRow, body_b), H5T_STD_U32LE));
  h5::check(H5Tinsert(type, "shape_a", offsetof(ContactForceRow, shape_a), H5T_STD_U32LE));
  h5::check(H5Tinsert(type, "shape_b", offsetof(ContactForceRow, shape_b), H5T_STD_U32LE));
  h5::check(H5Tinsert(type, "gap", offsetof(ContactForceRow, gap), H5T_IEEE_F64LE));
  h5::check(H5Tinsert(type, "point", offsetof(ContactForceRow, point), vector));
  h5::check(H5Tinsert(type, "normal", offsetof(ContactForceRow, normal), vector));
  h5::check(H5Tinsert(type, "force", offsetof(ContactForceRow, force), vector));
  return type;
}

h5::Handle input_row_type(u32 format) {
  constexpr hsize_t three = 3;
  const h5::Handle vector(H5Tarray_create2(H5T_IEEE_F64LE, 1, &three));
  h5::Handle type(H5Tcreate(H5T_COMPOUND, sizeof(InputRow)));
  h5::check(H5Tinsert(type, "step", offsetof(InputRow, step), H5T_STD_U32LE));
  h5::check(H5Tinsert(type, "body", offsetof(InputRow, body), H5T_STD_U32LE));
  h5::check(H5Tinsert(type, "kind", offsetof(InputRow, kind), H5T_STD_U32LE));
  h5::check(H5Tinsert(type, format < restores_format ? "reserved" : "row", offsetof(InputRow, row), H5T_STD_U32LE));
  h5::check(H5Tinsert(type, "linear", offsetof(InputRow, linear), vector));
  h5::check(H5Tinsert(type, "angular", offsetof(InputRow, angular), vector));
  return type;
}

}  // namespace lockstep
