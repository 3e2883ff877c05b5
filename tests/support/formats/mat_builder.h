#pragma once
#include <gtest/gtest.h>
#include <matio.h>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace tagtwist::internal {

/// Makes .mat files of any shape, right or wrong.
class MatBuilder {
 public:
  using Fields = std::vector<std::pair<std::string, matvar_t*>>;

  static matvar_t* Numbers(size_t rows, size_t columns, std::vector<double> values,
                           const char* name = nullptr) {
    values.resize(std::max<size_t>(1, rows * columns));
    std::array<size_t, 2> dims = {rows, columns};
    return Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dims.data(), values.data(), 0);
  }
  static matvar_t* Floats(size_t rows, size_t columns, std::vector<float> values) {
    std::array<size_t, 2> dims = {rows, columns};
    return Mat_VarCreate(nullptr, MAT_C_SINGLE, MAT_T_SINGLE, 2, dims.data(), values.data(), 0);
  }
  static matvar_t* Integers(size_t rows, size_t columns, std::vector<int32_t> values) {
    std::array<size_t, 2> dims = {rows, columns};
    return Mat_VarCreate(nullptr, MAT_C_INT32, MAT_T_INT32, 2, dims.data(), values.data(), 0);
  }
  static matvar_t* Bytes(std::vector<size_t> dims, std::vector<uint8_t> values) {
    return Mat_VarCreate(nullptr, MAT_C_UINT8, MAT_T_UINT8, static_cast<int>(dims.size()),
                         dims.data(), values.data(), 0);
  }
  static matvar_t* Text(std::string text) {
    std::array<size_t, 2> dims = {1, text.size()};
    return Mat_VarCreate(nullptr, MAT_C_CHAR, MAT_T_UINT8, 2, dims.data(), text.data(), 0);
  }

  /// Adds a struct variable; every packet has the fields of the first, in its order.
  void AddPackets(const std::vector<Fields>& packets, const char* name = "data") {
    std::array<size_t, 2> dims = {1, packets.size()};
    std::vector<const char*> names;
    for (const auto& field : packets.at(0)) names.push_back(field.first.c_str());
    matvar_t* const out = Mat_VarCreateStruct(name, 2, dims.data(), names.data(),
                                              static_cast<unsigned>(names.size()));
    for (size_t i = 0; i < packets.size(); ++i) {
      for (const auto& [field, value] : packets[i]) {
        if (value != nullptr) Mat_VarSetStructFieldByName(out, field.c_str(), i, value);
      }
    }
    variables_.push_back(out);
  }
  void Add(matvar_t* variable) { variables_.push_back(variable); }

  /// Writes the file and forgets the variables.
  void Write(const std::string& path, bool compressed = true, mat_ft version = MAT_FT_MAT5) {
    mat_t* const file = Mat_CreateVer(path.c_str(), "MATLAB 5.0 MAT-file", version);
    ASSERT_NE(file, nullptr);
    for (matvar_t* variable : variables_) {
      EXPECT_EQ(
          Mat_VarWrite(file, variable, compressed ? MAT_COMPRESSION_ZLIB : MAT_COMPRESSION_NONE),
          0);
      Mat_VarFree(variable);
    }
    variables_.clear();
    Mat_Close(file);
  }

 private:
  std::vector<matvar_t*> variables_;
};

}  // namespace tagtwist::internal
