// Pictures and page of the results of any study.
#pragma once

#include <filesystem>
#include <string>

namespace quoin::ensemble {

class Pictures {
 public:
  Pictures(const std::filesystem::path& folder, const std::string& title) : folder_(folder), title_(title) {}
  // Draws FOLDER/NAME.png by a gnuplot script that reads NAME.dat. x, y: labels of the axes.
  void draw(const std::string& name, const std::string& data, const std::string& x, const std::string& y,
            const std::string& script, const std::string& caption);
  const std::string& figures() const { return figures_; }  // as HTML

 private:
  std::filesystem::path folder_;
  std::string title_, figures_;
};

// Writes FOLDER/index.html. body: HTML below the title.
void write_page_of(const std::filesystem::path& folder, const std::string& title, const std::string& body);

}  // namespace quoin::ensemble
