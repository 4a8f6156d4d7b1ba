#include "host/record/recording_tables.hpp"

#include <cstddef>
#include <initializer_list>

namespace lockstep {

namespace {

struct Member {
  const char* name;
  std::size_t offset;
  hid_t type;
};

h5::Handle row_type(std::size_t size, std::initializer_list<Member> members) {
  h5::Handle type(H5Tcreate(H5T_COMPOUND, size));
  for (const Member& member : members) h5::check(H5Tinsert(type, member.name, member.offset, member.type));
  return type;
}

h5::Handle vector_type() {
  constexpr hsize_t three = 3;
  return h5::Handle(H5Tarray_create2(H5T_IEEE_F64LE, 1, &three));
}

}  // namespace

h5::Handle step_row_type() {
  return row_type(sizeof(StepRow), {{"step", offsetof(StepRow, step), H5T_STD_U32LE},
                                    {"pairs", offsetof(StepRow, pairs), H5T_STD_U32LE},
                                    {"contacts", offsetof(StepRow, contacts), H5T_STD_U32LE},
                                    {"redone", offsetof(StepRow, redone), H5T_STD_U32LE},
                                    {"milliseconds", offsetof(StepRow, milliseconds), H5T_IEEE_F64LE}});
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
  const h5::Handle vector = vector_type();
  return row_type(sizeof(ContactForceRow), {{"body_a", offsetof(ContactForceRow, body_a), H5T_STD_U32LE},
                                            {"body_b", offsetof(ContactForceRow, body_b), H5T_STD_U32LE},
                                            {"shape_a", offsetof(ContactForceRow, shape_a), H5T_STD_U32LE},
                                            {"shape_b", offsetof(ContactForceRow, shape_b), H5T_STD_U32LE},
                                            {"gap", offsetof(ContactForceRow, gap), H5T_IEEE_F64LE},
                                            {"point", offsetof(ContactForceRow, point), vector},
                                            {"normal", offsetof(ContactForceRow, normal), vector},
                                            {"force", offsetof(ContactForceRow, force), vector}});
}

h5::Handle input_row_type(u32 format) {
  const h5::Handle vector = vector_type();
  const char* row = format < restores_format ? "reserved" : "row";
  return row_type(sizeof(InputRow), {{"step", offsetof(InputRow, step), H5T_STD_U32LE},
                                     {"body", offsetof(InputRow, body), H5T_STD_U32LE},
                                     {"kind", offsetof(InputRow, kind), H5T_STD_U32LE},
                                     {row, offsetof(InputRow, row), H5T_STD_U32LE},
                                     {"linear", offsetof(InputRow, linear), vector},
                                     {"angular", offsetof(InputRow, angular), vector}});
}

}  // namespace lockstep
