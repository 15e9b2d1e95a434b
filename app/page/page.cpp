#include "app/page/page.hpp"

#include <string_view>

#include "app/page/html_json.hpp"
#include "app/page/html_text.hpp"
#include "app/page/page_template.hpp"

namespace ceilmap::page {
namespace {

std::string Fill(std::string_view connect, const std::string& title, std::string_view document) {
  const std::string_view page = PageTemplate();
  std::string filled;
  filled.reserve(page.size() + title.size() + document.size());
  std::size_t done = 0;
  // Each key is searched behind the one before, so that inserted text is never taken for a key.
  const auto put = [&](std::string_view place, std::string_view text) {
    const std::size_t at = page.find(place, done);
    filled.append(page, done, at - done).append(text);
    done = at + place.size();
  };
  put("{{connect}}", connect);
  put("{{title}}", EscapedForHtml(title));
  put("{{document}}", document);
  filled.append(page, done);
  return filled;
}

}  // namespace

std::string WritePage(const PageData& data) {
  return Fill("img-src data:", data.title, WriteDocument(data));
}

std::string WriteServedPage(const std::string& title, const std::string& document_url) {
  const nlohmann::ordered_json where = {{"title", title}, {"document_url", document_url}};
  return Fill("img-src data: 'self'; connect-src 'self'", title, DumpForHtml(where));
}

}  // namespace ceilmap::page
