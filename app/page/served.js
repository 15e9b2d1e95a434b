// A page that is served while the run goes on: it asks for the document again and again.

const pollInterval = 500;     // ms after the last answer
const longestInterval = 5000;  // after failures
const answerTimeout = 10000;

class Poller {
  /**
   * @param revision  function that tells which revision the page shows.
   * @param onAnswer  called with what came.
   * @param onFailure  called when nobody answers.
   */
  constructor(url, revision, onAnswer, onFailure) {
    Object.assign(this, {url, revision, onAnswer, onFailure, interval: pollInterval, asksForAll: true});
    this.poll();
  }

  async poll() {
    try {
      const query = this.asksForAll ? '' : `?revision=${this.revision()}`;
      const answer = await fetch(this.url + query,
                                 {cache: 'no-store', signal: AbortSignal.timeout(answerTimeout)});
      if (!answer.ok) throw new Error(`answer ${answer.status}`);
      this.onAnswer(await answer.json());
      this.interval = pollInterval;
      this.asksForAll = false;
    } catch (error) {
      this.onFailure(error);
      this.asksForAll = true;  // it may be another run that answers next
      this.interval = Math.min(2 * this.interval, longestInterval);
    }
    setTimeout(() => this.poll(), this.interval);
  }
}
