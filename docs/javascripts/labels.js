// SPDX-FileCopyrightText: 2026 The fpnet_ros developers
// SPDX-License-Identifier: Apache-2.0
//
// What the theme leaves unnamed: its search, and what has to be reached by keyboard to be scrolled.
function label() {
  document.querySelector('.md-search')?.setAttribute('aria-label', 'Search');
  document.querySelectorAll('.md-code__nav').forEach((each, k) => {
    each.setAttribute('aria-label', `Code block ${k + 1}`);
  });
  for (const each of document.querySelectorAll('pre > code, .md-typeset__scrollwrap')) {
    each.setAttribute('tabindex', '0');
  }
}

// The theme wraps tables and adds buttons after the page has come.
label();
new MutationObserver(label).observe(document.body, {childList: true, subtree: true});
