# Writes COPY, the public header FILE as it is installed: it includes its like by their installed names.
# Run as a script: cmake -DFILE=... -DCOPY=... -P public_header.cmake
file(READ "${FILE}" text)
string(REGEX REPLACE "#include \"((frontend|residuals|estimator)/[^\"]*)\"" "#include <tagtwist/\\1>" text "${text}")
file(WRITE "${COPY}" "${text}")
