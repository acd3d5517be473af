#pragma once

#include <cstdlib>
#include <string>

#include <catch2/catch.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "io/json.hpp"
#include "temporary_folder.hpp"

namespace leeway::test {

/// Chromium without a window: draws a page and reads back what a reader sees.
class Browser {
 public:
  static bool is_installed() { return std::system("command -v chromium >/dev/null 2>&1") == 0; }

  /// What read_page.js finds on the page, after everything on it that can be chosen was chosen.
  io::Json read(std::string html) const {
    const std::string scripts = LEEWAY_SOURCE_FOLDER "/tests/gap/report/";
    insert(html, "<main", script(scripts + "watch_page.js"));
    insert(html, "</body>", script(scripts + "read_page.js"));
    const std::string dom = browse(html, "--dump-dom");
    const std::string mark = "id=\"reading\">";
    const std::size_t begin = dom.find(mark);
    INFO(dom.substr(dom.size() - std::min<std::size_t>(dom.size(), 2000)));
    REQUIRE(begin != std::string::npos);
    const std::size_t from = begin + mark.size();
    return io::parse_json(dom.substr(from, dom.find("</script>", from) - from), "what was read back");
  }

  /// The page as a PNG.
  std::string picture(const std::string& html) const {
    browse(html, "--screenshot='" + folder_ / "page.png'");
    return io::read_text(folder_ / "page.png");
  }

 private:
  static std::string script(const std::string& path) { return "<script>" + io::read_text(path) + "</script>\n"; }

  static void insert(std::string& html, const std::string& before, const std::string& text) {
    const std::size_t at = html.rfind(before);
    REQUIRE(at != std::string::npos);
    html.insert(at, text);
  }

  // What the browser prints.
  std::string browse(const std::string& html, const std::string& what) const {
    folder_.write("page.html", html);
    const std::string command = fmt::format(
        "cd '{0}' && HOME='{0}' timeout 120 chromium --headless --no-sandbox --disable-gpu --disable-quic "
        "--no-first-run --disable-dev-shm-usage --disable-background-networking --disable-component-update "
        "--disable-sync --user-data-dir='{0}/profile' --hide-scrollbars --window-size=1280,3600 "
        "--virtual-time-budget=10000 {1} 'file://{0}/page.html' > page.out 2> browser.log < /dev/null",
        folder_.path().string(), what);
    INFO(command);
    REQUIRE(std::system(command.c_str()) == 0);
    return io::read_text(folder_ / "page.out");
  }

  TemporaryFolder folder_;
};

}  // namespace leeway::test
