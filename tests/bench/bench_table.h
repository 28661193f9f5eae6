#pragma once

#include <cstdio>
#include <string>
#include <vector>

namespace lightbatch::bench {

/// What was measured, a row for each figure and a column for each scene.
class BenchTable {
 public:
  void add(const std::string& what, const std::string& reach, const std::string& scene,
           double value) {
    const std::size_t column = index_of(scenes_, scene);
    std::size_t row = 0;
    while (row < rows_.size() && rows_[row].what != what) ++row;
    if (row == rows_.size()) rows_.push_back({what, reach, {}});
    std::vector<std::string>& cells = rows_[row].cells;
    if (cells.size() <= column) cells.resize(column + 1);
    char text[32];
    std::snprintf(text, sizeof text, "%.2f", value);
    cells[column] = text;
  }

  void print() const {
    if (rows_.empty()) return;
    std::printf("\n%-36s %-12s", "what", "reach");
    for (const std::string& scene : scenes_) std::printf(" %10s", scene.c_str());
    std::printf("\n");
    for (const Row& row : rows_) {
      std::printf("%-36s %-12s", row.what.c_str(), row.reach.c_str());
      for (const std::string& cell : row.cells) std::printf(" %10s", cell.c_str());
      std::printf("\n");
    }
  }

 private:
  struct Row {
    std::string what, reach;
    std::vector<std::string> cells;
  };

  static std::size_t index_of(std::vector<std::string>& names, const std::string& name) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i] == name) return i;
    }
    names.push_back(name);
    return names.size() - 1;
  }

  std::vector<std::string> scenes_;
  std::vector<Row> rows_;
};

}  // namespace lightbatch::bench
