// Hides the categories of objects that lack one of the words of the search box.
const box = document.getElementById("search");
const cards = [...document.querySelectorAll("article")];
box?.addEventListener("input", () => {
  const words = box.value.toLowerCase().split(/\s+/).filter(Boolean);
  let count = 0;
  for (const card of cards) {
    card.hidden = !words.every((word) => card.dataset.words.includes(word));
    count += card.hidden ? 0 : 1;
  }
  document.getElementById("shown").textContent = words.length ? `${count} of ${cards.length}` : "";
});
