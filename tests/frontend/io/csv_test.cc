#include "frontend/io/tables/csv.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tagtwist::internal::csv_test {
namespace {

CsvTable ParseGood(const std::string& text) {
  auto table = CsvTable::Parse(text, "x.csv");
  EXPECT_TRUE(table) << table.error().message;
  return std::move(*table);
}

std::string FaultOf(const std::string& text) {
  const auto table = CsvTable::Parse(text, "x.csv");
  return table ? "no fault" : table.error().message;
}

TEST(Csv, FindsColumnsByName) {
  const CsvTable table = ParseGood("t,file,x\n0.5,a.png,-2e3\n1.5,b.png,+4\n");
  const auto columns = table.RequireColumns({"x", "t"});
  ASSERT_TRUE(columns);
  ASSERT_EQ(table.rows(), 2u);
  EXPECT_EQ(*table.Numbers(0, *columns), (std::vector<double>{-2000.0, 0.5}));
  EXPECT_EQ(*table.Number(1, 2), 4.0);
  EXPECT_EQ(table.Cell(1, 1), "b.png");
  EXPECT_EQ(*table.Seconds(1, 0), 1'500'000'000);
  EXPECT_EQ(table.line(1), 3);
  EXPECT_FALSE(table.FindColumn("y"));
}

TEST(Csv, TakesCrlfBlankTailByteOrderMarkAndSpaces) {
  const CsvTable table = ParseGood("\xEF\xBB\xBFt , x\r\n 1 ,2\r\n3, 4 \r\n\r\n \n\n");
  ASSERT_EQ(table.rows(), 2u);
  EXPECT_EQ(table.columns(), (std::vector<std::string>{"t", "x"}));
  EXPECT_EQ(table.Cell(1, 1), "4");
}

TEST(Csv, TakesEurocHeader) {
  const CsvTable table = ParseGood("#timestamp [ns],p_RS_R_x [m], q_RS_w []\n7,1,2\n");
  EXPECT_EQ(table.columns(), (std::vector<std::string>{"timestamp", "p_RS_R_x", "q_RS_w"}));
}

TEST(Csv, ATableOutlivesMoves) {
  CsvTable a = ParseGood("t\n1\n");
  const CsvTable b = std::move(a);
  EXPECT_EQ(b.Cell(0, 0), "1");
}

TEST(Csv, NamesLineAndFault) {
  EXPECT_EQ(FaultOf(""), "x.csv: empty file");
  EXPECT_EQ(FaultOf("\n\r\n"), "x.csv: empty file");
  EXPECT_EQ(FaultOf("t,x\n1,2\n1,2,3\n"), "x.csv:3: expected 2 columns, got 3");
  EXPECT_EQ(FaultOf("t,x\n1,2\n1"), "x.csv:3: expected 2 columns, got 1");
  EXPECT_EQ(FaultOf("t,x\n\n1,2\n"), "x.csv:2: expected a row, got an empty line");
  EXPECT_EQ(FaultOf("1,2\n3,4\n"), "x.csv:1: expected a header line with the columns' names");
  EXPECT_EQ(FaultOf("t,x,t\n"), "x.csv:1: column 't' appears twice");
  const CsvTable table = ParseGood("t,x\nnan,abc\n1,inf\n,1e999\n1 2,3 4\n");
  EXPECT_EQ(table.RequireColumns({"t", "y"}).error().message, "x.csv:1: missing column 'y'");
  EXPECT_EQ(table.Seconds(0, 0).error().message,
            "x.csv:2: t: expected a time in seconds, got 'nan'");
  EXPECT_EQ(table.Number(0, 1).error().message, "x.csv:2: x: expected a finite number, got 'abc'");
  EXPECT_EQ(table.Number(1, 1).error().message, "x.csv:3: x: expected a finite number, got 'inf'");
  EXPECT_EQ(table.Seconds(2, 0).error().message, "x.csv:4: t: expected a time in seconds, got ''");
  EXPECT_EQ(table.Integer(2, 0).error().message, "x.csv:4: t: expected an integer, got ''");
  EXPECT_FALSE(table.Number(2, 1)) << "out of a double's range";
  EXPECT_FALSE(table.Number(3, 1)) << "two numbers in a cell";
}

TEST(Csv, MissingFileIsNamed) {
  const auto table = CsvTable::Read("/nonexistent/x.csv");
  ASSERT_FALSE(table);
  EXPECT_EQ(table.error().message, "/nonexistent/x.csv: cannot open: No such file or directory");
}

TEST(NumberText, SecondsAreExact) {
  EXPECT_EQ(ParseSeconds("1499735676.510662"), 1499735676510662000);
  EXPECT_EQ(ParseSeconds("1403636579.763555527"), 1403636579763555527);
  EXPECT_EQ(ParseSeconds("0"), 0);
  EXPECT_EQ(ParseSeconds("7."), 7'000'000'000);
  EXPECT_EQ(ParseSeconds(".5"), 500'000'000);
  EXPECT_EQ(ParseSeconds("+0.25"), 250'000'000);
  EXPECT_EQ(ParseSeconds("-1.000000001"), -1'000'000'001);
  EXPECT_EQ(ParseSeconds("-0.000000001"), -1);
}

TEST(NumberText, SecondsRoundAtTheTenthDecimal) {
  EXPECT_EQ(ParseSeconds("0.01723003387451172"), 17230034);
  EXPECT_EQ(ParseSeconds("0.0000000005"), 1);
  EXPECT_EQ(ParseSeconds("-0.0000000005"), -1);
  EXPECT_EQ(ParseSeconds("0.00000000049999999"), 0);
  EXPECT_EQ(ParseSeconds("0.00000000055555555"), 1);
  EXPECT_EQ(ParseSeconds("0.99999999951234567"), 1'000'000'000);
}

TEST(NumberText, SecondsTakeExponents) {
  EXPECT_EQ(ParseSeconds("1.5e-3"), 1'500'000);
  EXPECT_EQ(ParseSeconds("-2E2"), -200'000'000'000);
}

TEST(NumberText, SecondsRefuse) {
  for (const char* text : {"", ".", "-", "+", "--1", "+-1", "nan", "inf", "1e300", "1.2.3", "1 ",
                           "0x10", "99999999999", "-99999999999", "12s"}) {
    EXPECT_FALSE(ParseSeconds(text)) << text;
  }
}

TEST(NumberText, FormattedSecondsReadBack) {
  EXPECT_EQ(FormatSeconds(1499735676510662000), "1499735676.510662000");
  EXPECT_EQ(FormatSeconds(-1), "-0.000000001");
  EXPECT_EQ(FormatSeconds(0), "0.000000000");
  for (const int64_t t_ns : {int64_t{1}, int64_t{-1'999'999'999}, int64_t{1403636579763555527}}) {
    EXPECT_EQ(ParseSeconds(FormatSeconds(t_ns)), t_ns);
  }
  EXPECT_EQ(FormatSeconds(std::numeric_limits<int64_t>::min()), "-9223372036.854775808");
}

TEST(NumberText, FormattedNumbersReadBack) {
  EXPECT_EQ(FormatNumber(0.1), "0.1");
  EXPECT_EQ(FormatNumber(3), "3");
  for (const double value : {1.0 / 3, -1e-300, 6.02214076e23, std::nextafter(1.0, 2.0)}) {
    EXPECT_EQ(ParseNumber(FormatNumber(value)), value);
  }
}

TEST(NumberText, QuotedTextIsOneShortLine) {
  EXPECT_EQ(QuoteForMessage("a\nb\x01"), "'a?b?'");
  EXPECT_EQ(QuoteForMessage(std::string(100, 'x')), "'" + std::string(40, 'x') + "...'");
}

}  // namespace
}  // namespace tagtwist::internal::csv_test
