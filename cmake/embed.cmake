# Writes OUTPUT, a C++ file that defines `std::span<const lockstep::EmbeddedFile> lockstep::SYMBOL()`: the named files, with
# their names relative to ROOT, as string literals.   cmake -DOUTPUT=.. -DSYMBOL=.. -DROOT=.. -DFILES=a;b -P embed.cmake
set(entries "")
foreach(file IN LISTS FILES)
  file(READ "${ROOT}/${file}" text)
  string(LENGTH "${text}" length)
  set(literal "")
  # string literals have a length limit in some compilers: cut into pieces that are joined by juxtaposition
  set(position 0)
  while(position LESS length)
    string(SUBSTRING "${text}" ${position} 8000 piece)
    string(APPEND literal "R\"__(${piece})__\"\n")
    math(EXPR position "${position} + 8000")
  endwhile()
  string(APPEND entries "    {\"${file}\",\n${literal}},\n")
endforeach()
file(WRITE "${OUTPUT}.new" "#include \"host/embedded.hpp\"

namespace lockstep {

std::span<const EmbeddedFile> ${SYMBOL}() {
  static const EmbeddedFile files[] = {
${entries}  };
  return files;
}

}  // namespace lockstep
")
execute_process(COMMAND ${CMAKE_COMMAND} -E copy_if_different "${OUTPUT}.new" "${OUTPUT}")
