# Hardening, by the system's compiler and linker (SECURITY.md).
include(CheckCXXCompilerFlag)

# Libraries are looked for where the system has them and nowhere else: an empty entry of a RUNPATH, as CMake pads
# them, is the folder that a program is started in.
set(CMAKE_SKIP_RPATH ON)
add_link_options(-Wl,-z,relro,-z,now)

# A program starts with the libraries that it uses, of the 285 that ours lead to: under sanitizers, too, for which gcc
# leaves this off.
add_link_options(-Wl,--as-needed)

# Stacks have guards, calls of the C library know the size of what they write to, indirect jumps end where some may.
add_compile_options(-fstack-protector-strong)
add_compile_options($<$<CONFIG:Release>:-D_FORTIFY_SOURCE=2>)  # sanitizers check more, and do not know these calls
check_cxx_compiler_flag(-fcf-protection TAGTWIST_HAS_CET)
if(TAGTWIST_HAS_CET)
  add_compile_options(-fcf-protection)
endif()
